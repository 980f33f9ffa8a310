#include "env/robot/places.hpp"

#include <utility>

#include <fmt/format.h>

#include "threewe/core/errors.hpp"

namespace threewe::env {
namespace {

void check(Options& options) {
  const auto refuse = [](bool wrong, const char* message) {
    if (wrong) throw ConfigError(message);
  };
  options.gate = options.gate.value_or(Gate::full);
  refuse(options.gate != Gate::full, "gate: with a backend it is 'full', the one that every Robot has");
  refuse(options.worlds != 1 || options.robots != 1 || options.threads != 1,
         "num_envs, num_robots, num_threads: with a backend there is one environment with one robot");
}

void require_sensor(const Runtime& robot, const std::string& backend, SensorType type, const char* observation) {
  if (robot.features().has(type)) return;
  throw ConfigError(fmt::format("observations: '{}' needs a {}, which '{}' lacks on backend '{}'", observation,
                                to_string(type), robot.profile().name, backend));
}

// Of sensors that the backend lacks nothing is observed, or it is an error.
void check(Options& options, const RobotPlace& place, const std::string& backend) {
  const Runtime& robot = place.robot();
  if (!robot.features().can_reset) {
    throw ConfigError(fmt::format("backend: '{}' cannot reset, which every episode begins with", backend));
  }
  if (place.world->truth_service() == nullptr) {
    throw ConfigError(
        fmt::format("backend: '{}' tells no truth about its robot, which rewards are made of; simulators do", backend));
  }
  Observed& observed = options.observed;
  if (observed.if_there) {
    observed.lidar = observed.lidar && robot.features().has(SensorType::lidar);
    observed.image = observed.image && robot.features().has(SensorType::camera);
  }
  if (observed.lidar) require_sensor(robot, backend, SensorType::lidar, "lidar");
  if (observed.image) require_sensor(robot, backend, SensorType::camera, "image");
  if (observed.depth) require_sensor(robot, backend, SensorType::camera, "depth");
  if (!observed.image && !observed.depth) return;
  const CameraSpec& camera = *robot.profile().camera;
  if (camera.width != options.image_width || camera.height != options.image_height) {
    throw ConfigError(fmt::format("image_size: the pictures of backend '{}' are ({}, {}), got ({}, {})", backend,
                                  camera.height, camera.width, options.image_height, options.image_width));
  }
}

}  // namespace

std::vector<RobotPlace> make_robot_places(Options& options, const World::Options& robot,
                                          const std::vector<std::string>& scenes) {
  check(options);
  if (robot.robots.size() != 1) throw ConfigError("an environment has one robot");
  if (scenes.empty()) throw ConfigError("scene: at least one is needed");
  World::Options wanted = robot;
  if (options.observed.image || options.observed.depth) {
    wanted.image_size = ImageSize{options.image_width, options.image_height};
  }
  std::vector<RobotPlace> places;
  for (const std::string& scene : scenes) {
    wanted.scene = scene;
    RobotPlace& place = places.emplace_back();
    place.world = std::make_unique<World>(wanted);
    check(options, place, robot.backend);
    const Body& body = place.robot().profile().body;
    place.scene = std::make_shared<const scene::Scene>(place.truth().scene());
    place.tables = std::make_shared<const scene::SceneTables>(place.scene, body.footprint, body.height);
  }
  return places;
}

RobotProfile hardware_of(const RobotPlace& place, const std::string& asked) {
  const RobotProfile& brought = place.robot().profile();
  RobotProfile profile = load_profile(asked);
  return brought.name == profile.name ? profile : brought;
}

}  // namespace threewe::env
