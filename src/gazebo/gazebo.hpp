// Backend `gazebo`: a robot in a world of Gazebo Harmonic, over Gazebo's own transport. Nothing of Gazebo's is linked
// or loaded: of other programs' libraries it needs ZeroMQ alone, which is loaded when a robot is first connected.
#pragma once

#include <memory>

#include "threewe/backend/world.hpp"

namespace threewe::gazebo {

/// Makes the world of one robot that Gazebo simulates, in a world that was exported for its scene and profile. Throws
/// ConfigError where ZeroMQ cannot be loaded, naming the package, and for options that the running world decides.
std::unique_ptr<backend::World> make_world(const backend::WorldOptions& options);

}  // namespace threewe::gazebo
