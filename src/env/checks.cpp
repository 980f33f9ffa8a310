#include "env/checks.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "sim/state.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::env {
namespace {

void require(bool ok, const std::string& message) {
  if (!ok) throw ConfigError(message);
}

void check_lidar(Options& options) {
  const RobotProfile& robot = options.hardware;
  if (!options.observed.lidar) return;
  require(robot.lidar.has_value(), fmt::format("observations: '{}' has no lidar", robot.name));
  const int beams = robot.lidar->beams;
  if (options.lidar_beams == 0) options.lidar_beams = beams;
  if (options.lidar_beams > 0 && beams % options.lidar_beams == 0) return;
  std::string divisors;
  for (int n = beams; n >= 8; --n) {
    if (beams % n == 0) divisors += fmt::format("{}{}", divisors.empty() ? "" : ", ", n);
  }
  throw ConfigError(fmt::format("lidar_beams: every k-th of the {} beams of '{}' can be observed: {}; got {}", beams,
                                robot.name, divisors, options.lidar_beams));
}

void check_pictures(const Options& options) {
  const RobotProfile& robot = options.hardware;
  if (!options.observed.image && !options.observed.depth) return;
  require(robot.camera.has_value(), fmt::format("observations: '{}' has no camera", robot.name));
  require(!options.observed.depth || robot.camera->depth,
          fmt::format("observations: the camera of '{}' measures no depth", robot.name));
  const int width = options.image_width;
  const int height = options.image_height;
  require(std::min(width, height) >= 1 && std::max(width, height) <= kMostImageSide,
          fmt::format("image_size: 1 to {} pixels each way, got ({}, {})", kMostImageSide, height, width));
  check(make_intrinsics(width, height, robot.camera->horizontal_fov));
}

}  // namespace

Options checked(Options options) {
  const RobotProfile& robot = options.hardware;
  if (options.observed.if_there) {
    options.observed.lidar = options.observed.lidar && robot.lidar;
    options.observed.image = options.observed.image && robot.camera;
  }
  require(!options.scenes.empty(), "scene: at least one is needed");
  require(options.worlds > 0 && options.worlds <= kMostWorlds,
          fmt::format("num_envs: 1 to {}, got {}", kMostWorlds, options.worlds));
  require(options.robots > 0 && options.robots <= kMostRobots,
          fmt::format("num_robots: 1 to {}, got {}", kMostRobots, options.robots));
  require(options.threads > 0, "num_threads: at least one is needed");
  options.threads = std::min(options.threads, options.worlds);
  if (!options.gate) options.gate = robot.lidar ? Gate::full : Gate::limits;
  require(options.max_steps > 0, fmt::format("max_steps: at least 1, got {}", options.max_steps));
  require(options.control_period > Duration::zero() && options.control_period % kControlPeriod == Duration::zero(),
          fmt::format("control_rate: 50 Hz over a whole number, such as 50, 25, 10 or 5; got {:.6g}",
                      1.0 / to_seconds(options.control_period)));
  require(options.localization_model.period % kControlPeriod == Duration::zero(),
          fmt::format("localization: corrections every {} s do not fit control periods of {} s",
                      to_seconds(options.localization_model.period), to_seconds(kControlPeriod)));
  check_lidar(options);
  check_pictures(options);
  return options;
}

void check_place(std::size_t world, std::size_t worlds, std::size_t robot, std::size_t robots) {
  if (world >= worlds) throw ContractError(fmt::format("env: there is no environment {}, only {}", world, worlds));
  if (robot >= robots) throw ContractError(fmt::format("robot: there is no robot {}, only {}", robot, robots));
}

std::size_t rays_of(const task::Task& task, const RobotProfile& robot) {
  require(task.rays() == 0 || robot.lidar,
          fmt::format("hardware: this task counts what a lidar could see, and '{}' has none", robot.name));
  return task.rays();
}

void check_actions(std::span<const float> actions, std::size_t rows) {
  if (actions.size() != 3 * rows) {
    throw ContractError(fmt::format("actions must have the shape ({}, 3)", rows));
  }
  const auto wrong = std::ranges::find_if(actions, [](float share) { return !std::isfinite(share); });
  if (wrong != actions.end()) {
    const auto at = static_cast<std::size_t>(wrong - actions.begin());
    throw ContractError(fmt::format("actions must be finite, but actions[{}, {}] is {}", at / 3, at % 3, *wrong));
  }
}

}  // namespace threewe::env
