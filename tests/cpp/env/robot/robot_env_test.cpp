// Environments around a robot, against the batch: with the truth for a mind they are the same, to the bit.
#include "threewe/env/robot/robot_env.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include "draw.hpp"
#include "task/object_nav.hpp"
#include "task/vln.hpp"
#include "threewe/backend/registry.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/task/tasks.hpp"

namespace threewe::env {
namespace {

struct Case {
  const char* name;
  TaskFactory task;
  std::vector<std::string> scenes;
  std::string hardware = "3we_standard_v2";
  NoiseLevel noise = NoiseLevel::realistic;
  bool image = false;
};

const TaskFactory kNavigation = [](const task::TaskContext& s) { return task::make_navigation(s, {.goals = 4}); };
const TaskFactory kExploration = [](const task::TaskContext& s) { return task::make_exploration(s); };

Options options_of(const Case& c) {
  Options options;
  options.task = c.task;
  options.observed.image = c.image;
  options.observed.depth = c.image && c.hardware == "3we_depth_v2";
  options.image_width = 48;
  options.image_height = 32;
  options.max_steps = 40;
  options.localization = Localization::truth;
  options.autoreset = Autoreset::disabled;
  return options;
}

Batch native(const Case& c) {
  Options options = options_of(c);
  for (const std::string& name : c.scenes) {
    options.scenes.push_back(std::make_shared<const scene::Scene>(scene::Scene::load(name)));
  }
  options.data_sheet = load_profile(c.hardware);
  options.hardware = with_noise(*options.data_sheet, c.noise);
  return Batch(std::move(options));
}

World::Options robot_of(const Case& c) {
  World::Options robot;
  robot.robots = {c.hardware};
  robot.noise = c.noise;
  robot.autonomy = autonomy_with("truth");
  return robot;
}

// All that can be told of an environment. What two zeros differ in is their sign, and nobody can tell them apart.
template <typename Env>
std::vector<double> told_by(const Env& env) {
  std::vector<double> told;
  const auto add = [&](const auto& values) { told.insert(told.end(), values.begin(), values.end()); };
  for (const Array& array : env.observations()) {
    if (array.field.type == task::Field::Type::float32) {
      std::vector<float> values(array.row_bytes / sizeof(float));
      std::memcpy(values.data(), array.data.data(), array.row_bytes);
      add(values);
    } else {
      for (const std::byte byte : array.data) told.push_back(std::to_integer<int>(byte));
    }
  }
  add(env.rewards());
  add(env.terminated());
  add(env.truncated());
  add(env.metrics());
  add(env.true_poses());
  add(env.scan_ages());
  return told;
}

void check_same(const Case& c, int episodes) {
  CAPTURE(c.name);
  Batch batch = native(c);
  RobotEnv robot(options_of(c), robot_of(c), c.scenes);
  REQUIRE(robot.metric_names() == batch.metric_names());
  Draw draw(5);
  for (int episode = 0; episode < episodes; ++episode) {
    CAPTURE(episode);
    Reset reset;
    if (episode % 3 == 0) reset.seed = static_cast<std::uint64_t>(1000 + episode);
    batch.reset({&reset, 1});
    robot.reset(reset);
    REQUIRE(told_by(robot) == told_by(batch));
    CHECK(robot.instruction() == batch.instruction(0));
    std::array<float, 3> action{};
    for (int step = 0; batch.done()[0] == 0; ++step) {
      CAPTURE(step);
      if (step % 8 == 0) {
        action = {static_cast<float>(draw(-0.4, 1.3)), static_cast<float>(draw(-0.5, 0.5)),
                  static_cast<float>(draw(-1.3, 1.3))};
      }
      batch.step(action);
      robot.step(action);
      REQUIRE(told_by(robot) == told_by(batch));
    }
  }
}

TEST_CASE("with the truth for a mind, a robot's environment is the batch's to the bit") {
  check_same({"navigation", kNavigation, {"office_v2", "apartment_v1"}}, 8);
  check_same({"navigation, ideal", kNavigation, {"office_v2"}, "3we_standard_v2", NoiseLevel::ideal}, 6);
  check_same({"exploration", kExploration, {"cluttered_v1"}}, 3);
  check_same({"object_nav", [](const task::TaskContext& s) { return task::make_object_nav(s); }, {"apartment_v1"}}, 3);
  check_same({"vln", task::make_vln, {"apartment_v1"}}, 3);
  check_same({"among people", kNavigation, {"dynamic_v1"}}, 3);
  check_same({"differential", kNavigation, {"corridor_v1"}, "turtlebot_like"}, 3);
}

TEST_CASE("pictures are the batch's to the bit") {
  check_same({"image", kNavigation, {"apartment_v1"}, "3we_standard_v2", NoiseLevel::realistic, true}, 1);
  check_same({"depth", kNavigation, {"apartment_v1"}, "3we_depth_v2", NoiseLevel::realistic, true}, 1);
}

std::string refused(Options options, const World::Options& robot,
                    const std::vector<std::string>& scenes = {"corridor_v1"}) {
  try {
    const RobotEnv env(std::move(options), robot, scenes);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "nothing";
}

TEST_CASE("what a backend lacks is named") {
  const Case c{"navigation", kNavigation, {"corridor_v1"}};
  Options gate = options_of(c);
  gate.gate = Gate::limits;
  CHECK(refused(gate, robot_of(c)) == "gate: with a backend it is 'full', the one that every Robot has");
  World::Options blind = robot_of(c);
  blind.robots = {"3we_base_v2"};
  CHECK(refused(options_of(c), blind) ==
        "observations: 'lidar' needs a lidar, which '3we_base_v2' lacks on backend 'mock'");
  Options explore = options_of({"exploration", kExploration, {"corridor_v1"}});
  explore.observed.lidar = false;
  CHECK(refused(explore, blind) == "hardware: this task counts what a lidar could see, and '3we_base_v2' has none");
}

TEST_CASE("a robot that hears instead of seeing drives too") {
  const Case c{"navigation", kNavigation, {"corridor_v1"}, "3we_base_v2"};
  Options options = options_of(c);
  options.observed.lidar = false;
  RobotEnv env(options, robot_of(c), c.scenes);
  env.reset({.seed = 2, .request = {.start = Pose2D{}, .goal = Vec2{2.0, 1.0}}});
  const double before = env.true_poses()[0];
  for (int step = 0; step < 10; ++step) env.step(std::vector<float>{0.5F, 0.0F, 0.0F});
  CHECK(env.true_poses()[0] > before + 0.1);
}

TEST_CASE("an action that is none is refused and changes nothing") {
  const Case c{"navigation", kNavigation, {"corridor_v1"}};
  RobotEnv env(options_of(c), robot_of(c), c.scenes);
  const std::vector<float> good{0.5F, 0.0F, 0.0F};
  CHECK_THROWS_WITH_AS(env.step(good), "step() before the first reset()", ContractError);
  CHECK_THROWS_WITH_AS(env.reset({}), "reset: the first episode needs a seed", ContractError);
  env.reset({.seed = 1});
  const auto before = told_by(env);
  CHECK_THROWS_WITH_AS(env.step(std::vector<float>{0.0F, NAN, 0.0F}),
                       "actions must be finite, but actions[0, 1] is nan", ContractError);
  CHECK(told_by(env) == before);
}

}  // namespace
}  // namespace threewe::env
