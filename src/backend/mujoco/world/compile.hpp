// Compiler of an exported scene into a MuJoCo model.
#pragma once

#include <array>
#include <span>
#include <string>

#include "backend/mujoco/world/library.hpp"
#include "threewe/scene/scene.hpp"

namespace threewe::backend::mujoco {

/// The bodies of robots and people: each is moved by itself.
struct PersonBodies {
  std::string trunk;                ///< from the knees up
  std::array<std::string, 2> legs;  ///< as `sim::legs_of` has them
};
PersonBodies bodies_of(const scene::Person& person);

/// Compiles MJCF: without rangefinders, since ours cast rays when they ping; with legs for all people. The model is the
/// caller's. Throws ConfigError where MuJoCo refuses it.
mjModel* compile(const Library& mj, const std::string& mjcf, std::span<const scene::Person> people);

}  // namespace threewe::backend::mujoco
