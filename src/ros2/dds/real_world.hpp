// The world of a real robot, in real time.
#pragma once

#include <memory>

#include "ros2/discovery.hpp"
#include "ros2/real.hpp"
#include "threewe/backend/world.hpp"

namespace threewe::ros2 {

/// See `make_world`.
std::unique_ptr<backend::World> make_real_world(const backend::WorldOptions& options);
/// With whom this process talks, by the variables of ROS 2 in its environment.
Discovery our_discovery();
/// See `discover`.
Graph discover_with_cyclone(Duration wall);

}  // namespace threewe::ros2
