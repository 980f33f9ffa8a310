// Contract checks of what a plug-in says of itself and of time.
#pragma once

#include <cstddef>
#include <string>

#include "backend/plugin.hpp"

namespace threewe::backend {

/// Throws ContractError when the features contradict themselves or the profile; `name` is the plug-in's.
void check_features(const std::string& name, const Features& features, const RobotProfile& profile);

/// The index of a sensor. Throws ContractError naming the nearest right one.
std::size_t find_sensor(const Features& features, const std::string& name);

/// Throws ContractError unless the reading was measured after the sensor's `newest` one, and not after `latest`.
void check_stamp(const PluginReading& reading, Time newest, Time latest);

/// Throws ContractError, naming the field, for what can be true of no robot.
void check_truth(const PluginTruth& truth);

}  // namespace threewe::backend
