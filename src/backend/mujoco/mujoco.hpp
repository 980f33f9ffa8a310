// MuJoCo backend. The library is no part of ours: it is loaded when a world is first made.
#pragma once

#include <memory>
#include <string>

#include "threewe/backend/world.hpp"

namespace threewe::backend::mujoco {

/// The version of MuJoCo that this backend was written for, and its package on PyPI: both belong together to the digit.
inline constexpr const char* kVersion = "4.0.0";
inline constexpr const char* kInstall = "pip install mujoco-core==4.0.0";

/// Where `libmujoco.so.4.0.0` is: the file itself, or its name alone, which the system's loader then looks for (the
/// default). Python says here where its package is. Must be given before the first world is made.
void use_library(std::string path);

/// Makes a world. Throws ConfigError where MuJoCo cannot be loaded, naming the command that installs it, and what any
/// simulated world throws. What cameras see is drawn by OpenGL, which EGL must offer once a camera looks.
std::unique_ptr<World> make_world(const WorldOptions& options);

}  // namespace threewe::backend::mujoco
