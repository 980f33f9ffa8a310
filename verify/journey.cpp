// One journey with everything on, told as a hash of all that the robot believed and was told, tick by tick:
//
//   verify_journey SEED          on every vector target that this machine has: fresh, and restored half-way
//   verify_journey SEED --lie    with the truth as it is, and with a simulator that lies about it
//
// One line a run: what it was, and its hash. Runs that should be equal print equal hashes.
#include <bit>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "robot/lying_world.hpp"
#include "threewe/backend/registry.hpp"
#include "threewe/core/targets.hpp"
#include "threewe/robot/robot.hpp"
#include "threewe/scene/episodes.hpp"

using namespace threewe;

namespace {

// FNV-1a over the bits of numbers.
class Hash {
 public:
  void add(std::uint64_t word) {
    for (int byte = 0; byte < 8; ++byte) {
      value_ = (value_ ^ (word >> (8 * byte) & 0xFF)) * 0x100000001B3ULL;
    }
  }
  void add(double number) { add(std::bit_cast<std::uint64_t>(number)); }
  void add(const Pose2D& p) { add(p.x), add(p.y), add(p.theta); }
  void add(const Velocity& v) { add(v.vx), add(v.vy), add(v.omega); }
  void add(const map::OccupancyGrid& grid) {
    for (const std::int8_t value : grid.data) add(static_cast<std::uint64_t>(static_cast<std::uint8_t>(value)));
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xCBF29CE484222325ULL;
};

// Where a seed's journey leads. Every second one is in the corridor, every third one by the differential robot.
struct Plan {
  backend::WorldOptions options;
  Vec2 goal;  // in `map`
};

Plan plan(std::uint64_t seed) {
  Plan plan;
  plan.options.scene = seed % 2 == 0 ? "office_v2" : "corridor_v1";
  plan.options.robots = {seed % 3 == 0 ? "turtlebot_like" : "3we_standard_v2"};
  plan.options.seed = seed;
  const RobotProfile profile = load_profile(plan.options.robots[0]);
  const scene::SceneTables tables(std::make_shared<const scene::Scene>(scene::Scene::load(plan.options.scene)),
                                  profile.body.footprint, profile.body.height);
  const scene::Episode episode = sample_episode(tables, seed, 0);
  plan.options.poses = {episode.start};
  plan.goal = inverse(episode.start) * episode.goal;
  return plan;
}

// All that the robot believes and is told from now on.
class Listener {
 public:
  explicit Listener(Robot& robot) : robot_(robot) {
    id_ = robot.runtime().observe([this](const TickView& tick) {
      hash_.add(static_cast<std::uint64_t>(tick.now.count()));
      hash_.add(tick.pose.map_from_base());
      hash_.add(tick.requested);
      hash_.add(tick.commanded.command);
      for (const double entry : tick.pose.covariance) hash_.add(entry);
    });
  }
  ~Listener() { robot_.runtime().unobserve(id_); }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  std::uint64_t hash() {
    hash_.add(robot_.get_map());
    return hash_.value();
  }

 private:
  Robot& robot_;
  Hash hash_;
  std::uint64_t id_ = 0;
};

void set_out(Robot& robot, const Plan& plan) {
  (void)robot.wait(robot.move_to(plan.goal.x, plan.goal.y, {.timeout = 8.0}));
  robot.stop();
}

void go_on(Robot& robot, const Plan& plan) {
  robot.set_velocity(0.2, 0.0, 0.4, 1.0);
  robot.sleep(0.6);
  (void)robot.wait(robot.move_to(plan.goal.x, plan.goal.y, {.timeout = 60.0}));
  (void)robot.wait(robot.explore(4.0));
}

// From the start to the end, without and with a detour that restoring undoes. A snapshot is taken in both.
std::uint64_t journey(const Plan& plan, bool restored) {
  World world(backend::make_world("mock", plan.options));
  Robot robot(world);
  set_out(robot, plan);
  const auto snapshot = robot.simulation()->save();
  if (restored) {
    (void)robot.wait(robot.rotate(2.0));
    robot.sleep(1.0);
    robot.simulation()->restore(snapshot);
  }
  Listener listener(robot);
  go_on(robot, plan);
  Hash hash;
  hash.add(listener.hash());
  hash.add(robot.simulation()->true_pose());
  return hash.value();
}

// What the robot does when the simulator tells the truth about it, and when it does not.
std::uint64_t drive(const Plan& plan, std::unique_ptr<backend::World> backend) {
  World world(std::move(backend));
  Robot robot(world);
  Listener listener(robot);
  set_out(robot, plan);
  go_on(robot, plan);
  return listener.hash();
}

void print(const std::string& run, std::uint64_t hash) {
  std::printf("%s %016llx\n", run.c_str(), static_cast<unsigned long long>(hash));
}

}  // namespace

int main(int argc, char** argv) {
  std::uint64_t seed = 0;
  const std::string_view text = argc > 1 ? argv[1] : "";
  const bool lie = argc == 3 && std::strcmp(argv[2], "--lie") == 0;
  const bool parsed = std::from_chars(text.begin(), text.end(), seed).ptr == text.end() && !text.empty();
  if (!parsed || (argc == 3 && !lie) || argc > 3) {
    std::fputs("usage: verify_journey SEED [--lie]\n", stderr);
    return 2;
  }

  const Plan where = plan(seed);
  if (lie) {
    print("truth", drive(where, backend::make_world("mock", where.options)));
    print("lies", drive(where, std::make_unique<LyingWorld>(backend::make_world("mock", where.options))));
    return 0;
  }
  for (const std::string& target : available_targets()) {
    force_target(target);
    print(target + " fresh", journey(where, false));
    print(target + " restored", journey(where, true));
  }
  return 0;
}
