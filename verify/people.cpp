// How well a robot that drives among people sees them:
//
//   verify_people SCENE SEED SECONDS
//
// One line of JSON. At each scan the tracks are held against where people truly are; truth is looked at here and
// nowhere else. Who counts is within 5 m and in sight of the lidar for a second at least, whatever people may hide one
// another.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "number.hpp"
#include "threewe/robot/robot.hpp"
#include "threewe/robot/warning.hpp"
#include "threewe/scene/scene.hpp"
#include "threewe/scene/solid.hpp"

using namespace threewe;

namespace {

constexpr double kSight = 5.0;     // [m]
constexpr double kNear = 0.5;      // [m] a track so near to somebody is theirs
constexpr double kWalking = 0.05;  // [m/s] at least, who does not wait: people stop for robots only
constexpr Duration kSeenFor = 1s;
constexpr Duration kScan = 100ms;

struct Counts {
  int seen = 0;                           // people in sight, at all scans
  int missed = 0;                         // of them without a track
  int tracks = 0;                         // at all scans
  int ghosts = 0;                         // of them without anybody near
  int people = 0;                         // tracks, each counted once
  int false_tracks = 0;                   // that never were with anybody
  int swaps = 0;                          // tracks that go on with somebody else
  double position = 0.0, velocity = 0.0;  // sums of squares of errors
  int matched = 0;
  int waiting = 0;  // people who stand, at all scans
};

struct Truth {
  std::string name;
  Vec2 position;
  Vec2 velocity;
  Duration in_sight{};
  int looks = 0;
};

// People and their velocities, from one scan to the next.
class Crowd {
 public:
  explicit Crowd(const scene::Scene& scene) : slice_(scene.at_height(0.135)) {}

  void look(const std::vector<scene::PersonPose>& people, Vec2 lidar) {
    for (const scene::PersonPose& person : people) {
      const Vec2 at = person.pose.position();
      Truth& truth = people_[person.name];
      truth.velocity = (1.0 / to_seconds(kScan)) * (at - (truth.name.empty() ? at : truth.position));
      truth.name = person.name;
      truth.position = at;
      ++truth.looks;
      const Vec2 d = at - lidar;
      const double free = scene::cast_ray(slice_, lidar, std::atan2(d.y, d.x), kSight);
      const bool visible = norm(d) < kSight && free > norm(d) - person.radius;
      truth.in_sight = visible ? truth.in_sight + kScan : 0ns;
    }
  }
  const std::map<std::string, Truth>& people() const { return people_; }

 private:
  scene::Slice slice_;
  std::map<std::string, Truth> people_;
};

class Referee {
 public:
  // `scene_from_odom`: where the tracks' frame truly lies now.
  void judge(std::span<const perception::TrackedPerson> tracks, const Crowd& crowd, const Pose2D& scene_from_odom) {
    std::map<std::string, int> found;
    for (const perception::TrackedPerson& track : tracks) {
      ++counts.tracks;
      const Vec2 at = scene_from_odom * track.position;
      const Truth* nearest = nullptr;
      for (const auto& [name, truth] : crowd.people()) {
        if (nearest == nullptr || distance(truth.position, at) < distance(nearest->position, at)) nearest = &truth;
      }
      if (nearest == nullptr || distance(nearest->position, at) > kNear) {
        ++counts.ghosts;
        owners_.try_emplace(track.id);
        continue;
      }
      ++found[nearest->name];
      std::string& owner = owners_[track.id];
      if (!owner.empty() && owner != nearest->name) ++counts.swaps;
      owner = nearest->name;
      const Vec2 off = at - nearest->position;
      const Vec2 faster = rotate(track.velocity, scene_from_odom.theta) - nearest->velocity;
      counts.position += dot(off, off);
      counts.velocity += dot(faster, faster);
      ++counts.matched;
    }
    for (const auto& [name, truth] : crowd.people()) {
      if (truth.looks > 1 && norm(truth.velocity) < kWalking) ++counts.waiting;
      if (truth.in_sight < kSeenFor) continue;
      ++counts.seen;
      if (!found.contains(name)) ++counts.missed;
    }
  }
  Counts total() const {
    Counts all = counts;
    all.people = static_cast<int>(owners_.size());
    all.false_tracks = static_cast<int>(std::ranges::count_if(owners_, [](const auto& o) { return o.second.empty(); }));
    return all;
  }
  Counts counts;

 private:
  std::map<std::uint32_t, std::string> owners_;
};

void run(const std::string& scene, std::uint64_t seed, Duration duration) {
  Robot robot({.scene = scene, .seed = seed});
  Simulation& simulation = *robot.simulation();
  simulation.reset(seed, simulation.sample_free_pose(seed));
  Crowd crowd(simulation.scene());
  Referee referee;
  MotionHandle motion;
  std::uint64_t goals = 0;
  for (Time begun = robot.now(); robot.now() - begun < duration;) {
    if (!robot.runtime().motion()) {
      const Pose2D goal = simulation.sample_free_pose(seed * 1000 + ++goals);
      const Vec2 in_map = (inverse(simulation.start_pose()) * goal).position();
      motion = robot.move_to(in_map.x, in_map.y);
    }
    for (Duration t{}; t < kScan; t += kControlPeriod) robot.world().tick();
    const Pose2D base = simulation.true_pose();
    crowd.look(simulation.people(), (base * Pose2D{0.04, 0.0, 0.0}).position());
    referee.judge(robot.get_people(), crowd, base * inverse(robot.runtime().pose().odom_from_base));
  }
  const Counts c = referee.total();
  const double matched = std::max(1, c.matched);
  fmt::print(
      R"({{"seed": {}, "seconds": {:.1f}, "seen": {}, "missed": {}, "tracks": {}, "ghosts": {}, "people": {}, "false_tracks": {}, "swaps": {}, "position": {:.4f}, "velocity": {:.4f}, "matched": {}, "waiting": {:.2f}, "contact": {:.3f}}})"
      "\n",
      seed, to_seconds(duration), c.seen, c.missed, c.tracks, c.ghosts, c.people, c.false_tracks, c.swaps,
      std::sqrt(c.position / matched), std::sqrt(c.velocity / matched), c.matched,
      60.0 * c.waiting * to_seconds(kScan) / to_seconds(duration), simulation.max_collision_speed());
}

}  // namespace

int main(int argc, char** argv) {
  const auto seed = parse_number(argc == 4 ? argv[2] : "");
  const auto seconds = parse_number(argc == 4 ? argv[3] : "");
  if (!seed || !seconds) {
    std::fputs("usage: verify_people SCENE SEED SECONDS\n", stderr);
    return 2;
  }
  set_warning_handler([](std::string_view) {});
  run(argv[1], *seed, std::chrono::seconds(*seconds));
  return 0;
}
