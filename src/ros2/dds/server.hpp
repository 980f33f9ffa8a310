// The server of simulated robots on Cyclone DDS.
#pragma once

#include <memory>

#include "ros2/serve.hpp"

namespace threewe::ros2 {

/// See `serve`.
std::unique_ptr<Server> serve_with_cyclone(std::unique_ptr<backend::World> world, const ServeOptions& options);

}  // namespace threewe::ros2
