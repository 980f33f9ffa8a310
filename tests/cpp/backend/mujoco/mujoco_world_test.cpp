#if THREEWE_WITH_MUJOCO
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "backend/mock/mock_world.hpp"
#include "backend/mujoco/world/library.hpp"
#include "backend/mujoco/worlds.hpp"
#include "backend/twins.hpp"
#include "core/exact.hpp"
#include "threewe/backend/conformance.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::backend {
namespace {

using namespace testing;

WorldOptions in_small_room(NoiseLevel noise) { return testing::in_small_room("3we_standard_v2", noise); }

std::unique_ptr<World> make(const WorldOptions& options) { return connected(options); }

TEST_CASE("a metre driven is a metre in odometry, lidar and truth") {
  const auto world = make(in_small_room(NoiseLevel::ideal));
  const scene::TruthView& truth = world->truth_service()->truth(0);
  Readings before;
  Readings after;
  drive(*world, {}, 25, before);
  drive(*world, {0.4, 0.0, 0.0}, 130, after);
  drive(*world, {}, 50, after);
  const double driven = truth.true_pose().x;
  CHECK(driven == doctest::Approx(1.0).epsilon(0.05));
  CHECK(truth.distance_driven() == doctest::Approx(driven).epsilon(0.002));
  CHECK(ahead(before.scan) - ahead(after.scan) == doctest::Approx(driven).epsilon(0.002));
  CHECK(after.odometry.pose.x == doctest::Approx(driven).epsilon(0.02));
}

TEST_CASE("left is left, and a turn is counter-clockwise") {
  const auto world = make(in_small_room(NoiseLevel::ideal));
  const scene::TruthView& truth = world->truth_service()->truth(0);
  Readings readings;
  drive(*world, {0.0, 0.3, 0.0}, 100, readings);
  CHECK(truth.true_velocity().vy ==
        doctest::Approx(0.3).epsilon(0.06));  // rollers lose some, see docs/how-to-export.md
  drive(*world, {}, 50, readings);
  CHECK(truth.true_pose().y == doctest::Approx(0.6).epsilon(0.1));
  CHECK(readings.odometry.pose.y == doctest::Approx(truth.true_pose().y).epsilon(0.06));
  drive(*world, {0.0, 0.0, 0.8}, 75, readings);
  CHECK(truth.true_velocity().omega == doctest::Approx(0.8).epsilon(0.06));
  drive(*world, {}, 50, readings);
  CHECK(truth.true_pose().theta == doctest::Approx(1.2).epsilon(0.1));
  CHECK(readings.odometry.pose.theta == doctest::Approx(truth.true_pose().theta).epsilon(0.06));
}

TEST_CASE("the same seed gives the same bits, another seed others; a reset begins anew") {
  WorldOptions options = in_small_room(NoiseLevel::realistic);
  options.seed = 4;
  const auto world = make(options);
  const auto twin = make(options);
  drive_anyhow(*world, 11, 0, 20);
  drive_anyhow(*twin, 11, 0, 20);
  const std::vector<std::byte> after = world->save();
  CHECK(twin->save() == after);
  world->reset({.seed = 4});
  drive_anyhow(*world, 11, 0, 20);
  CHECK(world->save() == after);
  world->reset({.seed = 5});
  drive_anyhow(*world, 11, 0, 20);
  CHECK(world->save() != after);
}

TEST_CASE("a restored world goes on to the bit, in itself and in another") {
  const auto world = make(in_small_room(NoiseLevel::realistic));
  const auto other = make(in_small_room(NoiseLevel::realistic));
  drive_anyhow(*world, 12, 0, 7);
  const std::vector<std::byte> saved = world->save();
  drive_anyhow(*world, 12, 7, 8);
  const std::vector<std::byte> after = world->save();
  world->restore(saved);
  CHECK(world->save() == saved);
  other->restore(saved);
  drive_anyhow(*world, 12, 7, 8);
  drive_anyhow(*other, 12, 7, 8);
  CHECK(world->save() == after);
  CHECK(other->save() == after);

  std::vector<std::byte> broken(saved.begin(), saved.end() - 1);
  CHECK_THROWS_AS(world->restore(broken), ContractError);
  CHECK(world->save() == after);
  CHECK_THROWS_AS(make(in_small_room(NoiseLevel::ideal))->restore(saved), ContractError);
}

TEST_CASE("its lidar sees what the embedded simulator's does, from anywhere in the office") {
  WorldOptions options;
  options.noise = NoiseLevel::ideal;
  const auto world = make(options);
  mock::MockWorld mock(options);
  mock.robot(0).connect();
  constexpr int kPoses = 100;
  std::size_t beams = 0;
  std::size_t differ = 0;
  Readings seen;
  Readings expected;
  for (std::uint64_t seed = 1; seed <= kPoses; ++seed) {
    const ResetOptions anywhere{.seed = seed, .poses = {world->truth_service()->truth(0).sample_free_pose(seed)}};
    world->reset(anywhere);
    mock.reset(anywhere);
    drive(*world, {}, 10, seen);
    drive(mock, {}, 10, expected);
    REQUIRE(seen.scan.ranges.size() == expected.scan.ranges.size());
    for (std::size_t i = 0; i < seen.scan.ranges.size(); ++i) {
      ++beams;
      if (std::abs(seen.scan.ranges[i] - expected.scan.ranges[i]) > 0.01F) ++differ;
    }
  }
  MESSAGE(differ << " of " << beams << " beams differ by more than 1 cm");
  CHECK(static_cast<double>(differ) <= 0.001 * static_cast<double>(beams));
}

TEST_CASE("a robot that is left alone stays where it is, on one floor and on patches") {
  for (const char* scene : {"office_v2", "outdoor_v1"}) {
    WorldOptions options;
    options.scene = scene;
    const auto world = make(options);
    world->advance_to(1s);
    const Pose2D before = world->truth_service()->truth(0).true_pose();
    world->advance_to(6s);
    const Pose2D after = world->truth_service()->truth(0).true_pose();
    CHECK_MESSAGE(distance(before.position(), after.position()) < 1e-5, scene);
    CHECK_MESSAGE(std::abs(after.theta - before.theta) < 1e-5, scene);
  }
}

TEST_CASE("a wall stops the robot, and the truth says how fast it came") {
  const auto world = make(in_small_room(NoiseLevel::ideal));
  const scene::TruthView& truth = world->truth_service()->truth(0);
  Readings readings;
  drive(*world, {0.4, 0.0, 0.0}, 50, readings);
  CHECK(truth.max_collision_speed() == 0.0);
  drive(*world, {0.4, 0.0, 0.0}, 600, readings);
  CHECK(truth.max_collision_speed() == doctest::Approx(0.4).epsilon(0.03));
  const double x = truth.true_pose().x;
  CHECK(x == doctest::Approx(4.32).epsilon(0.003));  // half a robot and half a wall before the wall's middle
  drive(*world, {0.4, 0.0, 0.0}, 50, readings);
  CHECK(truth.true_pose().x == doctest::Approx(x).epsilon(0.001));
}

TEST_CASE("a robot starts nowhere but on free floor, and a refused start changes nothing") {
  const auto world = make(in_small_room(NoiseLevel::realistic));
  drive_anyhow(*world, 13, 0, 5);
  const std::vector<std::byte> before = world->save();
  CHECK_THROWS_AS(world->reset({.seed = 1, .poses = {{4.5, 0.0, 0.0}}}), ConfigError);
  CHECK_THROWS_AS(world->reset({.seed = 1, .poses = {{100.0, 0.0, 0.0}}}), ConfigError);
  CHECK_THROWS_AS(world->teleport(0, {0.0, 3.0, 0.0}), ConfigError);
  CHECK(world->save() == before);
  world->teleport(0, {2.0, 1.0, 3.5});
  const Pose2D carried = world->truth_service()->truth(0).true_pose();
  CHECK(carried.x == 2.0);
  CHECK(carried.y == 1.0);
  CHECK(carried.theta == doctest::Approx(3.5 - 2.0 * exact::kPi));
}

TEST_CASE("an error inside MuJoCo is an error of ours, and where physics comes apart it says so") {
  constexpr double kNowhere = std::numeric_limits<double>::quiet_NaN();
  WorldOptions options = in_small_room(NoiseLevel::ideal);
  options.poses = {{0.512345678, 0.0, 0.0}};
  const auto world = make(options);
  {
    const mujoco::ErrorsThrown errors;
    constexpr int kNoSuchPart = -1;
    CHECK_THROWS_WITH_AS(mujoco::library().mj_stateSize(nullptr, kNoSuchPart), doctest::Contains("MuJoCo: "),
                         ContractError);
  }

  // everything that says where the robot is says nothing any more
  std::vector<std::byte> saved = world->save();
  const double x = truth(*world).true_pose().x;
  for (std::size_t i = 0; i + sizeof(double) <= saved.size(); ++i) {
    double value = 0.0;
    std::memcpy(&value, &saved[i], sizeof(double));
    if (value == x) std::memcpy(&saved[i], &kNowhere, sizeof(double));
  }
  world->restore(saved);
  CHECK_THROWS_WITH_AS(world->advance_to(world->now() + 100ms), doctest::Contains("came apart"), ContractError);
  world->reset({.seed = 1, .poses = options.poses});
  world->advance_to(100ms);
  CHECK(truth(*world).true_pose().x == doctest::Approx(x).epsilon(0.001));
}

TEST_CASE("the MuJoCo backend keeps the contract, whatever the robot") {
  for (const std::string robot : {"3we_depth_v2", "turtlebot_like"}) {
    std::size_t applied = 0;
    for (const CheckResult& result : check_backend(mujoco_world, testing::in_small_room(robot))) {
      CHECK_MESSAGE(result.passed(), robot << ": " << result.name << ": " << result.detail);
      if (result.outcome == Outcome::passed) ++applied;
    }
    MESSAGE(robot << ": " << applied << " of " << check_names().size() << " checks apply");
  }
}

TEST_CASE("every check catches a broken twin of the MuJoCo backend") {
  std::string before;
  for (const auto& [check, fault] : twins()) {
    if (check == std::exchange(before, check)) continue;  // the embedded simulator has all of a check's twins
    const WorldOptions options =
        testing::in_small_room(check == "sideways_is_refused" ? "turtlebot_like" : "3we_depth_v2");
    const CheckResult broken = check_backend(with_fault(mujoco_world, fault), options, check);
    CHECK_MESSAGE(broken.outcome == Outcome::failed, check << " does not catch its twin: " << broken.detail);
  }
}

}  // namespace
}  // namespace threewe::backend
#endif
