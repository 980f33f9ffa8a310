// Backend `real`: a robot that speaks ROS 2, driven over DDS. The DDS library is no part of ours: it is loaded when a
// world is first made.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "ros2/endpoint.hpp"
#include "threewe/backend/world.hpp"

namespace threewe::ros2 {

/// What installs the DDS library of the version that this backend was compiled for, on Debian and Ubuntu.
inline constexpr const char* kInstall = "apt install cyclonedds-dev";

/// Makes the world of one robot, whose profile has a `link:` section that says how it is reached. Throws ConfigError
/// where the DDS library cannot be loaded, naming the package, and for options that only simulators have.
std::unique_ptr<backend::World> make_world(const backend::WorldOptions& options);

/// The ROS 2 graph as it was found.
struct Graph {
  std::vector<Endpoint> endpoints;  ///< by topic
  std::string silence;              ///< where there is none, what was seen, and what to try
};
/// Looks for a time [wall], and counts messages meanwhile; with whom it looks is the environment's to say, as for a
/// world. Throws ConfigError as that does.
Graph discover(Duration wall);

}  // namespace threewe::ros2
