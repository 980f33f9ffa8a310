// What is always built: where this library was compiled without MuJoCo's headers, the backend says so.
#include "backend/mujoco/mujoco.hpp"

#include <utility>

#include <fmt/format.h>

#include "threewe/core/errors.hpp"
#if THREEWE_WITH_MUJOCO
#include "backend/mujoco/world/engine.hpp"
#include "backend/mujoco/world/library.hpp"
#include "backend/simulated/simulated_world.hpp"
#endif

namespace threewe::backend::mujoco {

#if THREEWE_WITH_MUJOCO

void use_library(std::string path) { set_library(std::move(path)); }

std::unique_ptr<World> make_world(const WorldOptions& options) {
  return std::make_unique<simulated::SimulatedWorld>(options, "3wemjco2", [](std::shared_ptr<const sim::Model> model) {
    return std::make_unique<MujocoEngine>(std::move(model));
  });
}

#else

void use_library(std::string) {}

std::unique_ptr<World> make_world(const WorldOptions&) {
  throw ConfigError(
      fmt::format("backend 'mujoco': this build of threewe has none, as MuJoCo's headers were not there when it was "
                  "compiled: {}, then build threewe again",
                  kInstall));
}

#endif

}  // namespace threewe::backend::mujoco
