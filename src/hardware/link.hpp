// The `link:` section of a robot profile: how the real robot is reached.
#pragma once

#include <string_view>

#include "core/config.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe {

/// Whether ROS 2 takes a name: parts of letters, digits and underscores, each after a slash, none with a digit first.
bool is_ros_name(std::string_view name);

/// Reads the section. `profile` has its sensors already. Throws ConfigError.
LinkSpec read_link(ConfigNode node, const RobotProfile& profile);

}  // namespace threewe
