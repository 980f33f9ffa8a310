// Three robots on their way among people, with everything on, told as a hash of all that they sensed, believed and were
// told, tick by tick:
//
//   verify_end_to_end_hash SEED          on every vector target that this machine has: fresh, and restored half-way
//   verify_end_to_end_hash SEED --false-truth    with the truth as it is, and with a simulator that falsifies it: by
//   our
//                                                autonomy stack, and by some that peek at the truth
//
// One line a run: what it was, and its hash. Runs that should be equal print equal hashes.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <deque>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "core/targets.hpp"
#include "hash.hpp"
#include "number.hpp"
#include "robot/false_truth_world.hpp"
#include "robot/peeking_autonomy.hpp"
#include "scene/episodes.hpp"
#include "scene/scene_tables.hpp"
#include "threewe/backend/registry.hpp"
#include "threewe/robot/robot.hpp"

using namespace threewe;

namespace {

// Of all that robots sense.
class SampleHash : public Hash {
 public:
  using Hash::add;
  void add(const Pose2D& p) { add(p.x), add(p.y), add(p.theta); }
  void add(const Velocity& v) { add(v.vx), add(v.vy), add(v.omega); }
  void add(const map::OccupancyGrid& grid) { add(std::span(grid.data)); }
  // a line for each kind of sensor
  void add(const LaserScan& scan) { add(std::span(scan.ranges)); }
  void add(const IMUData& imu) { add(std::span(imu.angular_velocity)), add(std::span(imu.linear_acceleration)); }
  void add(const Odometry& odometry) { add(odometry.pose), add(odometry.velocity); }
  void add(const BatteryState& battery) { add(battery.voltage), add(battery.current), add(battery.charge); }
  void add(const RangeData& echo) { add(echo.range); }
  void add(const Picture& picture) { add(std::span(picture.image().color)), add(std::span(picture.image().depth)); }
  void add(const Sample& sample) {
    constexpr std::uint64_t kLookedAt = 25;  // every so many pictures: to draw and to hash them takes long
    if (std::holds_alternative<Picture>(sample.data) && sample.sequence % kLookedAt != 0) return;
    add(std::uint64_t{sample.sensor});
    add(static_cast<std::uint64_t>(sample.measured.count()));
    std::visit([this](const auto& data) { add(data); }, sample.data);
  }
};

// Where a seed leads each of the robots.
struct Plan {
  backend::WorldOptions options;
  std::vector<Vec2> goals;  // in each robot's `map`
};

Plan plan(std::uint64_t seed) {
  constexpr double kApart = 1.0;  // [m] between two starts
  Plan plan;
  plan.options.scene = "dynamic_v1";
  plan.options.robots = {"3we_depth_v2", "turtlebot_like", "3we_base_v2"};
  plan.options.seed = seed;
  const auto scene = std::make_shared<const scene::Scene>(scene::Scene::load(plan.options.scene));
  std::uint32_t index = 0;
  for (const std::string& hardware : plan.options.robots) {
    const RobotProfile profile = load_profile(hardware);
    const scene::SceneTables tables(scene, profile.body.footprint, profile.body.height);
    const auto crowded = [&](const Pose2D& pose) {
      return std::ranges::any_of(plan.options.poses, [&](const Pose2D& other) {
        return distance(pose.position(), other.position()) < kApart;
      });
    };
    scene::Episode episode = sample_episode(tables, seed, index++);
    while (crowded(episode.start)) episode = sample_episode(tables, seed, index++);
    plan.options.poses.push_back(episode.start);
    plan.goals.push_back(inverse(episode.start) * episode.goal);
  }
  return plan;
}

// The robots of a world, each of which begins its motions at the same time as the others.
class Team {
 public:
  explicit Team(std::unique_ptr<backend::World> backend, const Autonomy& autonomy = {})
      : world_(std::move(backend), false, autonomy) {
    for (std::size_t i = 0; i < world_.robot_count(); ++i) robots_.emplace_back(world_, i);
  }
  std::deque<Robot>& robots() { return robots_; }

  void move(const std::function<MotionHandle(Robot&, std::size_t)>& begin) {
    std::vector<MotionHandle> motions;
    for (std::size_t i = 0; i < robots_.size(); ++i) motions.push_back(begin(robots_[i], i));
    for (const MotionHandle& motion : motions) world_.wait(motion);
  }

 private:
  World world_;
  std::deque<Robot> robots_;
};

// All that robots sense, believe and are told from now on.
class Listener {
 public:
  explicit Listener(Team& team) : robots_(team.robots()) {
    for (Robot& robot : robots_) {
      ids_.push_back(robot.runtime().observe([this](const TickView& tick) {
        hash_.add(static_cast<std::uint64_t>(tick.now.count()));
        for (const Sample& sample : tick.samples) hash_.add(sample);
        hash_.add(tick.pose.map_from_base());
        hash_.add(tick.requested);
        hash_.add(tick.commanded.command);
        for (const double entry : tick.pose.covariance) hash_.add(entry);
      }));
    }
  }
  ~Listener() {
    for (std::size_t i = 0; i < ids_.size(); ++i) robots_[i].runtime().unobserve(ids_[i]);
  }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  std::uint64_t hash() {
    for (Robot& robot : robots_) {
      if (robot.runtime().profile().lidar) hash_.add(robot.get_map());
    }
    return hash_.value();
  }

 private:
  std::deque<Robot>& robots_;
  SampleHash hash_;
  std::vector<std::uint64_t> ids_;
};

void drive_to_goals(Team& team, const Plan& plan, double timeout) {
  team.move([&](Robot& robot, std::size_t i) {
    return robot.move_to(plan.goals[i].x, plan.goals[i].y, {.timeout = timeout});
  });
}

void set_out(Team& team, const Plan& plan) { drive_to_goals(team, plan, 8.0); }

void go_on(Team& team, const Plan& plan) {
  for (Robot& robot : team.robots()) robot.set_velocity(0.2, 0.0, 0.4, 1.0);
  team.robots().front().sleep(0.6);
  drive_to_goals(team, plan, 40.0);
  team.move([](Robot& robot, std::size_t) {
    return robot.runtime().profile().lidar ? robot.explore(4.0).motion : robot.rotate(2.0, 0.1, 4.0);
  });
}

// From the start to the end, without and with a detour that restoring undoes. A snapshot is taken in both.
std::uint64_t drive_all(const Plan& plan, bool restored) {
  Team team(backend::make_world("mock", plan.options));
  set_out(team, plan);
  Simulation& simulation = *team.robots().front().simulation();
  const auto snapshot = simulation.save();
  if (restored) {
    team.move([](Robot& robot, std::size_t) { return robot.rotate(2.0); });
    team.robots().front().sleep(1.0);
    simulation.restore(snapshot);
  }
  Listener listener(team);
  go_on(team, plan);
  SampleHash hash;
  hash.add(listener.hash());
  for (Robot& robot : team.robots()) hash.add(robot.simulation()->true_pose());
  for (const scene::PersonPose& person : simulation.people()) hash.add(person.pose);
  return hash.value();
}

std::unique_ptr<backend::World> make_world(const Plan& plan, bool falsified) {
  std::unique_ptr<backend::World> world = backend::make_world("mock", plan.options);
  if (!falsified) return world;
  return std::make_unique<FalseTruthWorld>(std::move(world));
}

// What the robots do when the simulator states the truth about them and about people, and when it falsifies it.
std::uint64_t drive(const Plan& plan, bool falsified) {
  Team team(make_world(plan, falsified));
  Listener listener(team);
  set_out(team, plan);
  go_on(team, plan);
  return listener.hash();
}

// The same, for as long as it takes to see a difference, of robots whose autonomy stack peeks.
std::uint64_t drive(const Plan& plan, bool falsified, const PeekingAutonomy& twin) {
  std::unique_ptr<backend::World> world = make_world(plan, falsified);
  const Autonomy autonomy = twin.make(*world->truth_service());
  Team team(std::move(world), autonomy);
  Listener listener(team);
  set_out(team, plan);
  return listener.hash();
}

}  // namespace

int main(int argc, char** argv) {
  const auto seed = parse_number(argc > 1 ? argv[1] : "");
  const bool false_truth = argc == 3 && std::strcmp(argv[2], "--false-truth") == 0;
  if (!seed || (argc == 3 && !false_truth) || argc > 3) {
    std::fputs("usage: verify_end_to_end_hash SEED [--false-truth]\n", stderr);
    return 2;
  }

  const Plan where = plan(*seed);
  if (false_truth) {
    print_hash("truth", drive(where, false));
    print_hash("false truth", drive(where, true));
    for (const PeekingAutonomy& twin : kPeekingAutonomies) {
      print_hash(std::string("truth, peeking at ") + twin.at, drive(where, false, twin));
      print_hash(std::string("false truth, peeking at ") + twin.at, drive(where, true, twin));
    }
    return 0;
  }
  for (const std::string& target : available_targets()) {
    force_target(target);
    print_hash(target + " fresh", drive_all(where, false));
    print_hash(target + " restored", drive_all(where, true));
  }
  return 0;
}
