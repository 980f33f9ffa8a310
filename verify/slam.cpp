// How far our SLAM is off, and how far its model says it is:
//
//   verify_slam drive SCENE SEED     a robot that knows nothing drives to three sampled goals; a line per correction
//   verify_slam model NAME SEED      reads such lines, and says what a robot with that localisation would believe
//
// A line: time [s], delay [s], whether the robot is lost, true pose, believed pose, both in `map`; `model` gives it
// again with another believed pose. The last lines of a drive tell how each motion ended: "# reached".
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <iostream>
#include <memory>
#include <string>
#include <string_view>
#include <variant>

#include "models/localization_error.hpp"
#include "number.hpp"
#include "scene/episodes.hpp"
#include "scene/scene_tables.hpp"
#include "threewe/models/localization.hpp"
#include "threewe/robot/robot.hpp"

using namespace threewe;

namespace {

constexpr std::uint32_t kGoals = 3;  // one after another: the robot comes back to places that it knows

struct Correction {
  double time = 0.0;
  double delay = 0.0;
  int lost = 0;
  Pose2D truth;
  Pose2D believed;
};

void print(const Correction& c) {
  std::printf("%.3f %.4f %d %.5f %.5f %.6f %.5f %.5f %.6f\n", c.time, c.delay, c.lost, c.truth.x, c.truth.y,
              c.truth.theta, c.believed.x, c.believed.y, c.believed.theta);
}

// When the last of a scan's beams was measured.
Time end_of(const Sample& sample, const LaserScan& scan) {
  const auto beams = static_cast<double>(scan.ranges.size());
  return sample.measured + from_seconds(std::max(scan.time_increment, 0.0) * (beams - 1.0));
}

void drive(const std::string& name, std::uint64_t seed) {
  const auto scene = std::make_shared<const scene::Scene>(scene::Scene::load(name));
  const RobotProfile profile = load_profile(Robot::Options{}.hardware);
  const scene::SceneTables tables(scene, profile.body.footprint, profile.body.height);
  const scene::Episode first = sample_episode(tables, seed, 0);
  const Pose2D map_from_scene = inverse(first.start);
  Robot robot({.scene = name, .seed = first.seed, .start_pose = first.start});

  // each scan is a correction
  robot.runtime().observe([&](const TickView& tick) {
    for (const Sample& sample : tick.samples) {
      const auto* scan = std::get_if<LaserScan>(&sample.data);
      if (scan == nullptr) continue;
      print({.time = to_seconds(tick.now),
             .delay = to_seconds(tick.now - end_of(sample, *scan)),
             .lost = tick.pose.lost() ? 1 : 0,
             .truth = map_from_scene * robot.simulation()->true_pose(),
             .believed = tick.pose.map_from_base()});
    }
  });
  for (std::uint32_t i = 0; i < kGoals; ++i) {
    const Vec2 goal = map_from_scene * sample_episode(tables, seed, i).goal;
    const MoveResult result = robot.wait(robot.move_to(goal.x, goal.y));
    std::printf("# %s\n", std::string(to_string(result.reason)).c_str());
  }
}

void imitate(const std::string& name, std::uint64_t seed) {
  const models::LocalizationSpec spec = models::load_localization(name);
  const RngKey key{.seed = seed, .stream = Stream::localization};
  models::LocalizationState state;
  std::uint64_t number = 0;
  Correction c;
  while (std::cin >> c.time >> c.delay >> c.lost >> c.truth.x >> c.truth.y >> c.truth.theta >> c.believed.x >>
         c.believed.y >> c.believed.theta) {
    correct_localization(spec, key, number++, c.truth, {}, state);
    c.believed = state.map_from_base;
    print(c);
  }
}

}  // namespace

int main(int argc, char** argv) {
  const auto seed = parse_number(argc == 4 ? argv[3] : "");
  const std::string_view what = argc == 4 ? argv[1] : "";
  if (!seed || (what != "drive" && what != "model")) {
    std::fputs("usage: verify_slam drive SCENE SEED | verify_slam model NAME SEED\n", stderr);
    return 2;
  }
  if (what == "drive") {
    drive(argv[2], *seed);
  } else {
    imitate(argv[2], *seed);
  }
  return 0;
}
