// Several robots, people, and robots that differ from their profiles, on MuJoCo.
#if THREEWE_WITH_MUJOCO
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "backend/mock/mock_world.hpp"
#include "backend/mujoco/worlds.hpp"
#include "core/exact.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/scene/scene.hpp"

namespace threewe::backend {
namespace {

using namespace testing;

/// Robots in one room, noise off.
WorldOptions together(std::vector<std::string> robots, std::vector<Pose2D> poses) {
  WorldOptions options = in_small_room(robots.front(), NoiseLevel::ideal);
  options.robots = std::move(robots);
  options.poses = std::move(poses);
  return options;
}

TEST_CASE("a robot sees others, and not itself") {
  const auto world =
      connected(together({"3we_standard_v2", "3we_standard_v2"}, {{0.0, 0.0, 0.0}, {1.5, 0.0, exact::kPi}}));
  Readings first;
  Readings second;
  drive(*world, {}, 10, first, 0);
  drive(*world, {}, 10, second, 1);
  const RobotProfile& profile = world->robot(0).profile();
  const double length = 0.25;
  const double expected = 1.5 - profile.lidar->base_from_lidar.x - 0.5 * length;
  CHECK(ahead(first.scan) == doctest::Approx(expected).epsilon(0.01));
  CHECK(ahead(second.scan) == doctest::Approx(expected).epsilon(0.01));
  for (std::size_t i = 0; i < first.scan.ranges.size(); ++i) CHECK_MESSAGE(first.scan.ranges[i] > 1.0F, i);
}

TEST_CASE("a robot that drives into another pushes it on, and answers for that alone") {
  const auto world = connected(together({"3we_standard_v2", "turtlebot_like"}, {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}}));
  Readings readings;
  drive(*world, {0.3, 0.0, 0.0}, 200, readings);
  CHECK(truth(*world, 0).max_collision_speed() == doctest::Approx(0.3).epsilon(0.05));
  CHECK(truth(*world, 1).max_collision_speed() < 0.02);
  CHECK(truth(*world, 1).true_pose().x > 1.1);
  CHECK(truth(*world, 1).true_pose().x - truth(*world, 0).true_pose().x > 0.2);
}

TEST_CASE("starts of several robots are checked") {
  CHECK_THROWS_WITH_AS(connected(together({"3we_standard_v2", "3we_standard_v2"}, {{0.0, 0.0, 0.0}, {0.1, 0.0, 0.0}})),
                       doctest::Contains("overlaps robot 0"), ConfigError);
  CHECK_THROWS_WITH_AS(connected(together({"3we_standard_v2", "3we_standard_v2"}, {})),
                       doctest::Contains("too few for 2 robots"), ConfigError);
}

TEST_CASE("many robots that vary repeat to the bit, also from what was saved") {
  std::vector<Pose2D> poses;
  for (int i = 0; i < 6; ++i) poses.push_back({-0.5 + 0.5 * i, 0.6 * (i % 2), 0.3 * i});
  WorldOptions options = together(std::vector<std::string>(poses.size(), "3we_standard_v2"), poses);
  options.noise = NoiseLevel::realistic;
  options.randomization = "paper";
  options.seed = 5;
  const auto world = connected(options);
  const auto twin = connected(options);
  drive_anyhow(*world, 21, 0, 4);
  const std::vector<std::byte> saved = world->save();
  drive_anyhow(*world, 21, 4, 4);
  const std::vector<std::byte> after = world->save();
  twin->restore(saved);
  CHECK(twin->save() == saved);
  drive_anyhow(*twin, 21, 4, 4);
  CHECK(twin->save() == after);
  world->reset({.seed = 5, .poses = poses});
  drive_anyhow(*world, 21, 0, 8);
  CHECK(world->save() == after);
}

TEST_CASE("people walk, are seen as in the embedded simulator, and give way") {
  WorldOptions options;
  options.scene = "dynamic_v1";
  options.noise = NoiseLevel::ideal;
  options.seed = 3;
  const scene::Person visitor = scene::Scene::load(options.scene).people.front();
  const Vec2 middle = 0.5 * (visitor.route[0] + visitor.route[1]);
  options.poses = {{middle.x, middle.y, 0.0}};
  const auto world = connected(options);
  mock::MockWorld mock(options);
  mock.robot(0).connect();

  std::size_t beams = 0;
  std::size_t differ = 0;
  for (int second = 0; second < 12; ++second) {
    Readings seen;
    Readings expected;
    drive(*world, {}, 50, seen);
    drive(mock, {}, 50, expected);
    const auto people = truth(*world).people();
    const auto same = mock.truth_service()->truth(0).people();
    REQUIRE(people.size() == same.size());
    for (std::size_t i = 0; i < people.size(); ++i) {
      CHECK(distance(people[i].pose.position(), same[i].pose.position()) < 0.02);
      CHECK(distance(people[i].pose.position(), middle) > people[i].radius + 0.1);
    }
    for (std::size_t i = 0; i < seen.scan.ranges.size(); ++i) {
      ++beams;
      if (std::abs(seen.scan.ranges[i] - expected.scan.ranges[i]) > 0.01F) ++differ;
    }
  }
  MESSAGE(differ << " of " << beams << " beams differ by more than 1 cm");
  CHECK(static_cast<double>(differ) <= 0.005 * static_cast<double>(beams));  // both robots settle, and so do gaps
  CHECK(truth(*world).max_collision_speed() < 0.01);
}

TEST_CASE("somebody's legs stop a robot") {
  WorldOptions options;
  options.scene = "dynamic_v1";
  options.noise = NoiseLevel::ideal;
  options.seed = 3;
  const auto world = connected(options);
  const scene::PersonPose person = truth(*world).people().front();
  const double heading = person.pose.theta;
  const auto [sin, cos] = exact::sincos(heading);
  world->teleport(0, {person.pose.x + 0.5 * cos, person.pose.y + 0.5 * sin, heading + exact::kPi});
  Readings readings;
  drive(*world, {0.3, 0.0, 0.0}, 100, readings);
  CHECK(truth(*world).max_collision_speed() == doctest::Approx(0.3).epsilon(0.1));
  CHECK(distance(truth(*world).true_pose().position(), person.pose.position()) > 0.12);
}

/// How far a robot comes in half a second from rest, told 0.5 m/s.
double start_off(const std::string& randomization, NoiseLevel noise = NoiseLevel::ideal) {
  WorldOptions options = in_small_room("3we_standard_v2", noise);
  options.randomization = randomization;
  const auto world = connected(options);
  Readings readings;
  drive(*world, {}, 10, readings);
  const double before = truth(*world).true_pose().x;
  drive(*world, {0.5, 0.0, 0.0}, 15, readings);
  return truth(*world).true_pose().x - before;
}

TEST_CASE("mass, friction and motors vary as they do in the embedded simulator") {
  const double usual = start_off("none");
  CHECK(start_off(always("friction: 0.25")) < 0.8 * usual);  // its wheels spin
  CHECK(start_off(always("motor_lag: 6.0")) < 0.9 * usual);
  CHECK(start_off(always("mass: 1.5")) == doctest::Approx(usual).epsilon(0.05));  // grip grows with weight
  const double noisy = start_off(always("motor_noise: 0.1"));
  CHECK(noisy != usual);
  CHECK(noisy == doctest::Approx(usual).epsilon(0.1));
  CHECK(start_off(always("battery_charge: 0.0")) < 0.1 * usual);
  const NoiseLevel late = NoiseLevel::realistic;
  CHECK(start_off(always("command_latency: 3.0"), late) < 0.8 * start_off("none", late));
}

}  // namespace
}  // namespace threewe::backend
#endif
