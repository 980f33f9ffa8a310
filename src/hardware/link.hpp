// The `link:` section of a robot profile: how the real robot is reached.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/config.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe {

/// Whether ROS 2 takes a name: parts of letters, digits and underscores, each after a slash, none with a digit first.
bool is_ros_name(std::string_view name);

/// A sensor, and the message types that it may come as, the preferred one first.
struct Deliverable {
  std::string sensor;
  std::vector<std::string> types;
};
/// What this robot's sensors may come as; "depth" is the camera's second image.
std::vector<Deliverable> deliverables(const RobotProfile& profile);
/// Which sensor a message type is of, as a profile's section is called; empty for none.
std::string_view sensor_of(std::string_view type);
/// The types of velocities.
std::vector<std::string> command_types();

/// Reads the section. `profile` has its sensors already. Throws ConfigError.
LinkSpec read_link(ConfigNode node, const RobotProfile& profile);

}  // namespace threewe
