// Backend worlds of an environment around a robot, one for each scene.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "scene/scene_tables.hpp"
#include "sim/ray_caster.hpp"
#include "threewe/env/options.hpp"
#include "threewe/robot/runtime.hpp"
#include "threewe/robot/world.hpp"
#include "threewe/scene/truth_view.hpp"

namespace threewe::env {

struct RobotPlace {
  std::unique_ptr<World> world;
  std::shared_ptr<const scene::Scene> scene;
  std::shared_ptr<const scene::SceneTables> tables;
  std::shared_ptr<const sim::RayCaster> caster;  ///< of noise-free rays; null where nothing reads any

  Runtime& robot() { return world->robot(0); }
  const Runtime& robot() const { return std::as_const(*world).robot(0); }
  const scene::TruthView& truth() const { return world->truth_service()->truth(0); }
};

/// Makes the worlds, and leaves in the options what can be observed there. Throws ConfigError naming what their backend
/// lacks, or an option that robots have no use for.
std::vector<RobotPlace> make_robot_places(Options& options, const World::Options& robot,
                                          const std::vector<std::string>& scenes);

/// The robot as on its data sheet, where its backend has not brought one of its own. Its camera's view is not of the
/// size that was asked of the world.
RobotProfile hardware_of(const RobotPlace& place, const std::string& asked);

}  // namespace threewe::env
