// The border: what a plug-in says is checked before anything else sees it. Every message names sensor and field.
#pragma once

#include <cstddef>
#include <string>

#include "threewe/backend/plugin.hpp"

namespace threewe::backend {

/// Throws ContractError when the features contradict themselves or the profile; `name` is the plug-in's.
void check_features(const std::string& name, const Features& features, const RobotProfile& profile);

/// The index of a sensor. Throws ContractError naming the nearest right one.
std::size_t find_sensor(const Features& features, const std::string& name);

/// Throws ContractError unless a reading is what the profile's sensor of this type could measure: finite numbers, the
/// right number of beams, ranges that are 0 or within the limits, a heading in (-pi, pi], a charge within 0 to 1.
void check_reading(const PluginReading& reading, SensorType type, const RobotProfile& profile);

/// Throws ContractError unless the reading was measured after the sensor's `newest` one, and not after `latest`.
void check_stamp(const PluginReading& reading, Time newest, Time latest);

}  // namespace threewe::backend
