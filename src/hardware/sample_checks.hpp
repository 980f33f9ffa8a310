// Validation of samples: what no sensor of the robot can have measured is refused.
#pragma once

#include <span>

#include "core/bounds.hpp"
#include "threewe/core/samples.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe {

/// How far off a range or a depth may be that was kept as a float [m].
inline constexpr double kRangeTolerance = 1e-4;

/// Throws ContractError, naming sensor and field, unless `data` is what a sensor of this profile could measure: of its
/// type, finite, of sane size, the right number of beams, ranges that are 0 or within the lidar's limits, a heading in
/// (-pi, pi], a charge within 0 to 1.
void check_data(const SensorInfo& sensor, const SampleData& data, const RobotProfile& profile);

/// Throws ContractError unless a sample is of a sensor that the robot has, and of what that measures.
void check_kind(std::span<const SensorInfo> sensors, const Sample& sample);

/// Throws ContractError unless a sample is of a sensor that the robot has, was measured before it was received, and
/// holds what that sensor could measure.
void check_sample(std::span<const SensorInfo> sensors, const Sample& sample, const RobotProfile& profile);

}  // namespace threewe
