// Vectorised range noise, bias and dropout of a lidar.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "core/rng.hpp"

namespace threewe::models {

/// How far off points are, how many are lost, and what the device measures at all.
struct RangeNoise {
  float bias = 0.0F;     ///< [m]
  float sigma = 0.0F;    ///< [m]
  float dropout = 0.0F;  ///< probability
  float near = 0.0F;     ///< [m], nothing below is valid
  float far = 0.0F;      ///< [m], where nothing is
};

/// Turns true ranges [m] into measured ones, in place; `first` counts points from the beginning of the episode.
///
/// Two neighbours, points 2k and 2k + 1, share the words w of `random_bits(key, k)`. The first two words scatter them,
/// as a pair of normal numbers (Box & Muller 1958): sqrt(-2 ln u) times cosine and sine of 2 pi v, where u and v are
/// the middles of 2^23 equal steps. The others decide whether each is lost: w >> 8 is below dropout * 2^24.
void add_noise(const RngKey& key, std::uint64_t first, const RangeNoise& noise, std::span<float> ranges);

/// Appends which of so many points are lost by a probability of `dropout` above 0, counted from `first`, in order.
void append_dropped_points(const RngKey& key, std::uint64_t first, std::size_t count, float dropout,
                           std::pmr::vector<std::size_t>& list);

}  // namespace threewe::models
