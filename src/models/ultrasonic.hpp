// Ultrasonic noise model: the measured range of a sonar return.
#pragma once

#include <cstdint>

#include "core/rng.hpp"
#include "threewe/core/samples.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe::models {

/// The range [m] that ping number `ping` of one sensor measures of an echo from `echo` [m] away: 0 where that is too
/// near, range_max where none came back.
double measure_range(const UltrasonicSpec& spec, const RngKey& key, std::uint64_t ping, double echo);

/// A range as the contract wants it.
RangeData range_data(const UltrasonicSpec& spec, double range);

}  // namespace threewe::models
