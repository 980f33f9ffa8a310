// Backend `real`: a robot that speaks ROS 2, driven over DDS. The DDS library is no part of ours: it is loaded when a
// world is first made.
#pragma once

#include <memory>
#include <vector>

#include "ros2/endpoint.hpp"
#include "threewe/backend/world.hpp"

namespace threewe::ros2 {

/// What installs the DDS library of the version that this backend was compiled for, on Debian and Ubuntu.
inline constexpr const char* kInstall = "apt install cyclonedds-dev";

/// Makes the world of one robot, whose profile has a `link:` section that says how it is reached. Throws ConfigError
/// where the DDS library cannot be loaded, naming the package, and for options that only simulators have.
std::unique_ptr<backend::World> make_world(const backend::WorldOptions& options);

/// Every endpoint of the ROS 2 graph that is found within a time [wall], by topic; with whom it looks is the
/// environment's to say, as for a world. Throws ConfigError as that does.
std::vector<Endpoint> discover(Duration wall);

}  // namespace threewe::ros2
