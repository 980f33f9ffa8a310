// Observation arrays that a batch fills.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "threewe/env/batch.hpp"

namespace threewe::env {

/// Which arrays, in their order: those of `Observed`, then the task's.
std::vector<task::Field> observation_fields(const Options& options, const std::vector<task::Field>& task_fields);
/// Whether each of the task's is among them.
std::vector<bool> which_are_among(const std::vector<task::Field>& fields, const std::vector<task::Field>& task_fields);
/// One array for each field, of zeros.
std::vector<Array> make_arrays(const std::vector<task::Field>& fields, std::size_t rows);

/// Fills in one row, unless nothing reads it: three numbers, or every k-th beam of a scan, zeros before the first.
void put(const std::array<double, 3>& values, std::span<std::byte> to);
void put_scan(std::span<const float> scan, std::span<std::byte> to);

}  // namespace threewe::env
