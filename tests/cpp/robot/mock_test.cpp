// The whole path on the embedded simulator: what the robot believes, what is true, and whether it is the same again.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/exact.hpp"
#include "core/rng.hpp"
#include "robot/scripted_autonomy.hpp"
#include "threewe/backend/registry.hpp"
#include "threewe/core/assets.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/robot/robot.hpp"
#include "threewe/scene/scene.hpp"

using namespace threewe;

namespace {

// All that a robot was told and what became of it, tick by tick.
struct Record {
  explicit Record(Runtime& robot) : robot_(robot) {
    id_ = robot.observe([this](const TickView& view) {
      stamps.push_back(view.now);
      poses.push_back(view.pose.map_from_base());
      commands.push_back(view.commanded.command);
    });
  }
  ~Record() { robot_.unobserve(id_); }
  Record(const Record&) = delete;
  Record& operator=(const Record&) = delete;
  friend bool operator==(const Record& a, const Record& b) {
    return std::tie(a.stamps, a.poses, a.commands) == std::tie(b.stamps, b.poses, b.commands);
  }

  std::vector<Time> stamps;
  std::vector<Pose2D> poses;
  std::vector<Velocity> commands;

 private:
  Runtime& robot_;
  std::uint64_t id_ = 0;
};

// A drive with some of everything.
void drive(Robot& robot) {
  robot.set_velocity(0.3, 0.0, 0.5);
  robot.sleep(0.4);
  (void)robot.wait(robot.move_to(1.5, 0.5, {.timeout = 15.0}));
  (void)robot.wait(robot.rotate(1.0));
  robot.execute_action({0.5, 0.0, -0.5}, 0.1);
}

}  // namespace

TEST_CASE("five lines: the goal is reached in truth") {
  Robot robot;
  const MoveResult result = robot.wait(robot.move_to(2.0, 1.0));
  CHECK(result.success);
  CHECK(distance(robot.simulation()->true_pose().position(), {2.0, 1.0}) <= 0.25);
  CHECK(robot.simulation()->max_collision_speed() <= 0.05);
}

// A hall of 7 x 4 m with something round in it that is too low for a lidar.
std::string hall_with_a_low_thing(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder / "objects");
  std::ofstream(folder / "objects/sill.yaml")
      << "category: sill\nshapes:\n  low:\n    - {cylinder: 0.2, z: [0, 0.1], material: wood}\n";
  std::ofstream(folder / "low_hall.yaml")
      << "name: low_hall\ndescription: a hall\nstarts: [[2, 2]]\nwalls:\n  - {a: [0, 0], b: [7, 0], thickness: 0.1}\n"
         "  - {a: [7, 0], b: [7, 4], thickness: 0.1}\n  - {a: [7, 4], b: [0, 4], thickness: 0.1}\n"
         "  - {a: [0, 4], b: [0, 0], thickness: 0.1}\nobjects:\n"
         "  - {category: sill, shape: low, pose: [3.6, 2.1, 0], name: low_thing}\n";
  add_asset_directory(folder);
  return (folder / "low_hall.yaml").string();
}

TEST_CASE("what is too low for the lidar is heard, and driven round") {
  const auto folder = std::filesystem::temp_directory_path() / "threewe_low_hall_test";
  const std::string scene = hall_with_a_low_thing(folder);
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    CAPTURE(seed);
    Robot robot({.scene = scene, .seed = seed});
    CHECK(robot.wait(robot.move_to(3.5, 0.2)).success);
    CHECK(distance(robot.simulation()->true_pose().position(), {3.5, 0.2}) <= 0.25);
    CHECK(robot.simulation()->max_collision_speed() == 0.0);
    const map::OccupancyGrid& map = robot.get_map();
    CHECK(map.at(map.cell({1.45, 0.1})) <= map::OccupancyGrid::kFreeThreshold);  // its near side: no beam met it
  }
  std::filesystem::remove_all(folder);
}

// At full speed hither and thither, in creep mode for as long as the share of the time says.
Autonomy hostile(double share_of_creep_mode, std::uint64_t seed) {
  return test::scripted([=](const nav::Observation& seen) {
    const auto tick = static_cast<std::uint64_t>(seen.now / kControlPeriod);
    const RngKey key{.seed = seed};
    const std::uint64_t turn = tick / 100;
    const double way = uniform(key, turn, 0, -exact::kPi, exact::kPi);
    const Velocity velocity{std::cos(way), std::sin(way), uniform(key, turn, 1, -1.0, 1.0)};
    const bool creep_mode = uniform(key, tick / 30, 2, 0.0, 1.0) < share_of_creep_mode;
    return nav::Decision{velocity, Reason::running, "", creep_mode};
  });
}

TEST_CASE("a hostile navigator that claims creep mode touches nothing faster than 0.05 m/s") {
  for (const std::string hardware : {"3we_standard_v2", "turtlebot_like", "3we_base_v2"}) {
    for (const double share : {1.0, 0.5}) {
      if (share < 1.0 && hardware == "3we_base_v2") continue;  // sonar does not see all that it may run into at speed
      for (std::uint64_t seed = 0; seed < 3; ++seed) {
        CAPTURE(hardware);
        CAPTURE(share);
        CAPTURE(seed);
        Robot robot({.hardware = hardware, .scene = "cluttered_v1", .seed = seed, .autonomy = hostile(share, seed)});
        (void)robot.wait(robot.move_to(5.0, 0.0, {.timeout = 60.0}));
        CHECK(robot.simulation()->max_collision_speed() <= 0.05);
      }
    }
  }
}

TEST_CASE("a thorough exploration sees more, and takes longer") {
  const auto explored = [](bool thorough) {
    Robot robot({.scene = "apartment_v1", .seed = 3});
    return robot.wait(robot.explore(1800.0, thorough));
  };
  const ExploreResult usual = explored(false);
  const ExploreResult thorough = explored(true);
  CHECK(usual.success);
  CHECK(thorough.success);
  CHECK(usual.detail == "what is left to see is not worth the way: see `thorough`");
  CHECK(thorough.detail == "nothing that can be reached is left to see");
  CHECK(thorough.explored_area > usual.explored_area);
  CHECK(thorough.duration > usual.duration);
}

TEST_CASE("robots with one map frame explore together, sooner than one alone") {
  const auto explored = [](std::size_t robots, bool together, std::uint64_t seed) {
    World::Options options;
    options.seed = seed;
    options.scene = "apartment_v1";
    options.robots.assign(robots, "3we_standard_v2");
    options.poses = {{0.0, 0.0, 0.0}, {0.0, 0.6, 0.0}};
    options.poses.resize(robots);
    if (together) options.initial_poses = options.poses;
    World world(options);
    std::vector<std::unique_ptr<Robot>> team;
    std::vector<ExplorationHandle> work;
    for (std::size_t i = 0; i < robots; ++i) team.push_back(std::make_unique<Robot>(world, i));
    for (const auto& robot : team) work.push_back(robot->explore(900.0, true));
    double distance = 0.0;
    for (std::size_t i = 0; i < robots; ++i) {
      const ExploreResult result = team[i]->wait(work[i]);
      CHECK(result.success);
      CHECK(result.detail == "nothing that can be reached is left to see");
      // strangers that start 0.6 m apart do touch now and then: `./dev verify navigation` counts how often
      if (together) CHECK(team[i]->simulation()->max_collision_speed() <= 0.05);
      distance += result.distance;
    }
    return distance;
  };
  double shared = 0.0;  // [m] over several, for one alone may be lucky
  double apart = 0.0;
  for (std::uint64_t seed = 0; seed < 2; ++seed) {
    CAPTURE(seed);
    shared += explored(2, true, seed);
    apart += explored(2, false, seed);
  }
  CHECK(shared < 0.8 * apart);
}

TEST_CASE("the robot without a lidar stops at a wall by its ultrasonic sensors, and drives where nothing is") {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    CAPTURE(seed);
    Robot robot({.hardware = "3we_base_v2", .scene = "corridor_v1", .seed = seed});
    CHECK_THROWS_WITH_AS(robot.get_lidar_scan(), "robot '3we_base_v2' has no sensor 'lidar'", HardwareError);
    CHECK_THROWS_AS(robot.get_map(), HardwareError);
    CHECK_THROWS_AS((void)robot.explore(), HardwareError);
    const auto ranges = robot.get_ultrasonic_ranges();
    CHECK(ranges.size() == 4);
    CHECK(ranges.at("ultrasonic_left").range < ranges.at("ultrasonic_left").range_max);  // the corridor's wall
    CHECK(robot.wait(robot.move_to(1.0, 0.0)).success);
    CHECK(robot.simulation()->true_pose().x > 0.75);

    // sideways into the corridor's wall
    for (int i = 0; i < 400; ++i) robot.execute_action({0.0, 1.0, 0.0});
    CHECK(robot.runtime().commanded().intervention == safety::Intervention::stopped_for_obstacle);
    CHECK(robot.simulation()->max_collision_speed() == 0.0);
    CHECK(robot.simulation()->true_pose().y > 0.3);
    // and back out of there
    for (int i = 0; i < 50; ++i) robot.execute_action({0.0, -1.0, 0.0});
    CHECK(robot.simulation()->true_velocity().vy < -0.1);
  }
}

TEST_CASE("the robot without a lidar finds its way round what it hears") {
  int arrived = 0;
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    Robot robot({.hardware = "3we_base_v2", .seed = seed});
    if (!robot.wait(robot.move_to(2.0, 1.0)).success) continue;
    arrived += distance(robot.simulation()->true_pose().position(), {2.0, 1.0}) <= 0.25 ? 1 : 0;
  }
  CHECK(arrived >= 4);  // it has its own published success
}

TEST_CASE("a robot without ultrasonic sensors says so") {
  Robot robot({.hardware = "turtlebot_like", .scene = "corridor_v1"});
  CHECK_THROWS_WITH_AS(robot.get_ultrasonic_ranges(), "robot 'turtlebot_like' has no sensor 'ultrasonic'",
                       HardwareError);
}

TEST_CASE("the same seed gives the same drive to the bit, another seed another") {
  const auto driven = [](std::uint64_t seed) {
    Robot robot({.seed = seed});
    auto record = std::make_unique<Record>(robot.runtime());
    drive(robot);
    return std::pair(record->poses, record->commands);
  };
  CHECK(driven(3) == driven(3));
  CHECK(driven(3) != driven(4));
}

TEST_CASE("whoever looks at plans sees them while they are followed, and changes nothing") {
  const auto driven = [](bool looks) {
    Robot robot;
    auto record = std::make_unique<Record>(robot.runtime());
    int plans = 0;
    CHECK_FALSE(robot.get_plan().has_value());
    const MoveResult result = robot.wait(robot.move_to(1.0, 0.5), [&](const Progress&) {
      if (looks && robot.get_plan()) ++plans;
    });
    CHECK(result.success);
    CHECK((plans > 10) == looks);
    CHECK_FALSE(robot.get_plan().has_value());
    return std::pair(record->poses, record->commands);
  };
  CHECK(driven(true) == driven(false));
}

TEST_CASE("a restored world goes on as the one that was saved, to the bit") {
  for (std::uint64_t seed = 0; seed < 2; ++seed) {
    CAPTURE(seed);
    const std::string hardware = seed == 0 ? "3we_standard_v2" : "3we_base_v2";
    Robot robot({.hardware = hardware, .seed = seed});
    robot.set_velocity(0.2, 0.0, 0.3, 1.0);
    robot.sleep(0.5);  // in the middle of a hold
    const auto snapshot = robot.simulation()->save();
    const Time saved = robot.world().now();

    Record first(robot.runtime());
    drive(robot);
    robot.simulation()->restore(snapshot);
    CHECK(robot.world().now() == saved);
    Record second(robot.runtime());
    drive(robot);
    CHECK(first.stamps.size() > second.stamps.size());  // the first saw both drives
    CHECK(std::equal(second.commands.begin(), second.commands.end(), first.commands.begin()));
    CHECK(std::equal(second.poses.begin(), second.poses.end(), first.poses.begin()));

    Robot other({.hardware = hardware, .seed = seed + 100});
    other.simulation()->restore(snapshot);
    Record third(other.runtime());
    drive(other);
    CHECK(second == third);
  }
}

TEST_CASE("a world that was reset is as good as new") {
  Robot fresh({.seed = 5});
  Record expected(fresh.runtime());
  drive(fresh);

  Robot used({.seed = 9});
  drive(used);
  used.emergency_stop();
  used.simulation()->reset(5);
  Record record(used.runtime());
  drive(used);
  CHECK(record == expected);
}

TEST_CASE("a reset without a seed repeats the robot's own run") {
  Robot robot({.seed = 5});
  const auto driven = [&] {
    const Record record(robot.runtime());
    drive(robot);
    return record.commands;
  };
  const auto first = driven();
  robot.simulation()->reset(9);
  CHECK(driven() != first);
  robot.simulation()->reset();
  CHECK(driven() == first);
}

TEST_CASE("reset puts the robot where it is told to, and its map frame with it") {
  Robot robot;
  const Pose2D start = robot.simulation()->sample_free_pose(12);
  robot.simulation()->reset(1, start);
  CHECK(distance(robot.simulation()->true_pose().position(), start.position()) < 0.01);
  CHECK(distance(robot.get_pose().position(), {}) < 0.01);
  CHECK(robot.get_lidar_scan().ranges.size() == 360);
  CHECK_THROWS_AS(robot.simulation()->reset(1, Pose2D{500.0, 0.0, 0.0}), ConfigError);
}

TEST_CASE("saving needs a robot at rest between motions") {
  Robot robot;
  const MotionHandle motion = robot.move_to(2.0, 1.0);
  CHECK_THROWS_AS(robot.simulation()->save(), ContractError);
  motion->cancel();
  CHECK(robot.simulation()->save() != nullptr);
}

TEST_CASE("motions of several worlds are independent of how they take turns") {
  const auto goal_of = [](std::uint64_t seed) { return Vec2{1.0 + 0.2 * static_cast<double>(seed), 0.5}; };
  std::vector<MoveResult> alone;
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    Robot robot({.seed = seed});
    alone.push_back(robot.wait(robot.move_to(goal_of(seed).x, goal_of(seed).y)));
  }
  std::deque<Robot> robots;
  std::vector<MotionHandle> motions;
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    robots.emplace_back(Robot::Options{.seed = seed});
    motions.push_back(robots.back().move_to(goal_of(seed).x, goal_of(seed).y));
  }
  for (bool busy = true; busy;) {
    busy = false;
    for (std::size_t i = 0; i < robots.size(); ++i) {
      if (motions[i]->done()) continue;
      robots[i].world().tick();
      busy = true;
    }
  }
  for (std::size_t i = 0; i < robots.size(); ++i) {
    CHECK(motions[i]->result().success);
    CHECK(motions[i]->result().pose == alone[i].pose);
    CHECK(motions[i]->result().duration == alone[i].duration);
  }
}

TEST_CASE("names that nobody knows are refused with the nearest right one") {
  const auto message = [](const Robot::Options& options) -> std::string {
    try {
      Robot robot(options);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  };
  CHECK(message({.backend = "mok"}).find("'mock'") != std::string::npos);
  CHECK(message({.hardware = "3we_standart_v2"}).find("'3we_standard_v2'") != std::string::npos);
  CHECK(message({.scene = "ofice_v2"}).find("'office_v2'") != std::string::npos);
}

TEST_CASE("initial_pose shifts the map frame, start_pose the robot") {
  Robot robot({.initial_pose = Pose2D{1.0, 2.0, 0.5}, .start_pose = Pose2D{0.5, 0.0, 0.0}});
  CHECK(distance(robot.get_pose().position(), {1.0, 2.0}) < 0.01);
  CHECK(distance(robot.simulation()->true_pose().position(), {0.5, 0.0}) < 0.01);
  CHECK_THROWS_AS(Robot({.initial_pose = Pose2D{std::nan(""), 0.0, 0.0}}), ContractError);
}

TEST_CASE("a limit goes on with what it had left when time jumps, and no sleep outlives that") {
  Robot robot({.scene = "corridor_v1", .noise = NoiseLevel::ideal});
  World& world = robot.world();
  const auto snapshot = robot.simulation()->save();
  robot.sleep(0.6);
  const WaitHandle alarm = world.alarm(3s);
  robot.sleep(0.2);
  const WaitHandle sleep = world.sleep(10s);

  robot.simulation()->reset(0);  // waits until every sensor has delivered
  CHECK(sleep->done());
  CHECK_FALSE(alarm->done());
  CHECK(alarm->deadline() == 2800ms);
  robot.sleep(0.1);
  const Duration left = alarm->deadline() - world.now();
  robot.simulation()->restore(snapshot);
  CHECK(alarm->deadline() == world.now() + left);
  robot.sleep(to_seconds(left) - 0.02);
  CHECK_FALSE(alarm->done());
  robot.sleep(0.02);
  CHECK(alarm->done());
}

TEST_CASE("the middle of a tick cannot be saved") {
  Robot robot({.scene = "corridor_v1", .noise = NoiseLevel::ideal});
  int refused = 0;
  robot.runtime().observe([&](const TickView&) {
    try {
      (void)robot.simulation()->save();
    } catch (const ContractError&) {
      ++refused;
    }
  });
  robot.sleep(0.1);
  CHECK(refused == 5);
}

TEST_CASE("a goal that is not finite is named as it was given") {
  Robot robot({.scene = "corridor_v1", .noise = NoiseLevel::ideal});
  const double inf = std::numeric_limits<double>::infinity();
  CHECK_THROWS_WITH_AS(robot.move_to(0.0, inf, {.frame = "odom"}), "goal y must be finite, not inf", ContractError);
  CHECK_THROWS_WITH_AS(robot.move_to(0.0, 0.0, {.theta = inf, .frame = "base"}), "goal theta must be finite, not inf",
                       ContractError);
}

TEST_CASE("the options of a robot make its world") {
  World world(RobotOptions{.scene = "corridor_v1", .seed = 5, .start_pose = Pose2D{1.0, 0.0, 0.5}});
  CHECK(world.robot_count() == 1);
  CHECK(world.seed() == 5);
  CHECK(world.origin()->options.scene == "corridor_v1");
  CHECK(Simulation(world, 0).start_pose() == Pose2D{1.0, 0.0, 0.5});
}

TEST_CASE("a goal in another frame is where it is in the map, its heading too") {
  Robot robot({.scene = "corridor_v1", .noise = NoiseLevel::ideal, .initial_pose = Pose2D{2.0, 1.0, 3.0}});
  const nav::MoveTo goal{.goal = {0.5, -0.25}, .theta = 1.0};
  const nav::MoveTo there = robot.runtime().in_map(goal, "base");
  const Pose2D expected = robot.get_pose() * Pose2D{0.5, -0.25, 1.0};
  CHECK(distance(there.goal, expected.position()) < 1e-12);
  CHECK(std::fabs(wrap_angle(*there.theta - expected.theta)) < 1e-12);
  const nav::MoveTo same = robot.runtime().in_map(goal, "map");
  CHECK(same.goal == goal.goal);
  CHECK(*same.theta == *goal.theta);
  CHECK_THROWS_AS((void)robot.runtime().in_map(goal, "bse"), ContractError);
}
