#if THREEWE_WITH_MUJOCO
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "threewe/backend/conformance.hpp"
#include "threewe/backend/mock/mock_world.hpp"
#include "threewe/backend/mujoco/mujoco.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/core/rng.hpp"
#include "threewe/scene/truth_view.hpp"

namespace threewe::backend {
namespace {

/// One room without furniture, the robot's start 4.5 m from the wall ahead.
std::string small_room() {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "threewe_mujoco";
  std::filesystem::create_directories(folder);
  const std::filesystem::path file = folder / "small_room.yaml";
  std::ofstream(file) << R"(
name: small_room
description: A room of 6 x 5 m
starts:
  - [1.5, 2, 0]
rooms:
  - {name: room, min: [0, 0], max: [6, 5], floor: wood, anchor: [3, 2]}
walls:
  - {a: [0, 0], b: [6, 0]}
  - {a: [6, 0], b: [6, 5]}
  - {a: [6, 5], b: [0, 5]}
  - {a: [0, 5], b: [0, 0]}
)";
  return file.string();
}

WorldOptions in_small_room(NoiseLevel noise, const char* robot = "3we_standard_v2") {
  WorldOptions options;
  options.scene = small_room();
  options.robots = {robot};
  options.noise = noise;
  return options;
}

std::unique_ptr<World> make(const WorldOptions& options) {
  mujoco::use_library(MUJOCO_LIBRARY);
  auto world = mujoco::make_world(options);
  world->robot(0).connect();
  return world;
}

/// The newest data of one kind.
template <typename Data>
void keep_newest(std::vector<Sample>& samples, Data& newest) {
  for (Sample& sample : samples) {
    if (auto* data = std::get_if<Data>(&sample.data)) newest = std::move(*data);
  }
}

struct Readings {
  LaserScan scan;
  Odometry odometry;
};

/// Commands `velocity` for `periods` of 20 ms.
void drive(World& world, const Velocity& velocity, int periods, Readings& readings) {
  for (int i = 0; i < periods; ++i) {
    world.robot(0).command(velocity, world.now() + 200ms);
    world.advance_to(world.now() + kControlPeriod);
    std::vector<Sample> samples = world.robot(0).poll();
    keep_newest(samples, readings.scan);
    keep_newest(samples, readings.odometry);
  }
}

/// The same by random commands, which last 0.2 s each.
void drive_anyhow(World& world, std::uint64_t seed, int first, int count) {
  Readings unused;
  const RngKey key{.seed = seed};
  for (int i = first; i < first + count; ++i) {
    const auto draw = static_cast<std::uint64_t>(i);
    drive(world, {uniform(key, draw, 0, -0.5, 0.5), uniform(key, draw, 1, -0.5, 0.5), uniform(key, draw, 2, -1.0, 1.0)},
          10, unused);
  }
}

double ahead(const LaserScan& scan) {
  return scan.ranges[static_cast<std::size_t>(std::lround(-scan.angle_min / scan.angle_increment))];
}

std::string refusal(const WorldOptions& options) {
  try {
    make(options);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

TEST_CASE("a metre driven is a metre in odometry, lidar and truth") {
  const auto world = make(in_small_room(NoiseLevel::ideal));
  const scene::TruthView& truth = *world->robot(0).truth();
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
  const scene::TruthView& truth = *world->robot(0).truth();
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
    const ResetOptions anywhere{.seed = seed, .poses = {world->robot(0).truth()->sample_free_pose(seed)}};
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
    const Pose2D before = world->robot(0).truth()->true_pose();
    world->advance_to(6s);
    const Pose2D after = world->robot(0).truth()->true_pose();
    CHECK_MESSAGE(distance(before.position(), after.position()) < 1e-5, scene);
    CHECK_MESSAGE(std::abs(after.theta - before.theta) < 1e-5, scene);
  }
}

TEST_CASE("a wall stops the robot, and the truth says how fast it came") {
  const auto world = make(in_small_room(NoiseLevel::ideal));
  const scene::TruthView& truth = *world->robot(0).truth();
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
  CHECK_THROWS_AS(world->carry(0, {0.0, 3.0, 0.0}), ConfigError);
  CHECK(world->save() == before);
  world->carry(0, {2.0, 1.0, 3.5});
  const Pose2D carried = world->robot(0).truth()->true_pose();
  CHECK(carried.x == 2.0);
  CHECK(carried.y == 1.0);
  CHECK(carried.theta == doctest::Approx(3.5 - 2.0 * exact::kPi));
}

TEST_CASE("what cannot be simulated yet is refused by name") {
  WorldOptions people;
  people.scene = "dynamic_v1";
  CHECK(refusal(people).find("people") != std::string::npos);
  WorldOptions several;
  several.robots = {"3we_standard_v2", "3we_standard_v2"};
  CHECK(refusal(several).find("robots: 2") != std::string::npos);
  WorldOptions pictures;
  pictures.image_size = ImageSize{};
  CHECK(refusal(pictures).find("cameras") != std::string::npos);
  WorldOptions randomized;
  randomized.randomization = "paper";
  CHECK(refusal(randomized).find("'paper'") != std::string::npos);
}

TEST_CASE("the MuJoCo backend keeps the contract, with either robot") {
  for (const char* robot : {"3we_standard_v2", "turtlebot_like"}) {
    const WorldFactory factory = [](const WorldOptions& options) {
      mujoco::use_library(MUJOCO_LIBRARY);
      return mujoco::make_world(options);
    };
    for (const CheckResult& result : check_backend(factory, in_small_room(NoiseLevel::realistic, robot))) {
      CHECK_MESSAGE(result.passed(), robot << ": " << result.name << ": " << result.detail);
    }
  }
}

}  // namespace
}  // namespace threewe::backend
#endif
