// How well a robot that knows nothing keeps track of itself for minutes:
//
//   verify_trajectory SCENE SEED RANDOMIZATION SECONDS
//
// It drives to one sampled goal after another. A line per correction: time [s], whether the robot is lost, true pose,
// believed pose, both in `map`, and the covariance that it states: xx, xy, xt, yy, yt, tt. The last line tells what it
// took: "# driven [m], motions, of these reached, CPU [s], CPU of a tick that 99 % stay below [ms], of the longest
// [ms]"; the simulator's share is part of a tick.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "number.hpp"
#include "scene/episodes.hpp"
#include "scene/scene_tables.hpp"
#include "seconds.hpp"
#include "threewe/robot/robot.hpp"

using namespace threewe;

namespace {

double cpu_seconds() { return seconds_by(CLOCK_PROCESS_CPUTIME_ID); }

void print(const TickView& tick, const Pose2D& truth) {
  const Pose2D believed = tick.pose.map_from_base();
  const auto& c = tick.pose.covariance;
  std::printf("%.3f %d %.5f %.5f %.6f %.5f %.5f %.6f %.4g %.4g %.4g %.4g %.4g %.4g\n", to_seconds(tick.now),
              tick.pose.lost() ? 1 : 0, truth.x, truth.y, truth.theta, believed.x, believed.y, believed.theta, c[0],
              c[1], c[2], c[4], c[5], c[8]);
}

bool has_scan(const TickView& tick) {
  return std::ranges::any_of(tick.samples,
                             [](const Sample& sample) { return std::holds_alternative<LaserScan>(sample.data); });
}

void drive(const std::string& name, std::uint64_t seed, const std::string& randomization, double seconds) {
  const auto scene = std::make_shared<const scene::Scene>(scene::Scene::load(name));
  const RobotProfile profile = load_profile(Robot::Options{}.hardware);
  const scene::SceneTables tables(scene, profile.body.footprint, profile.body.height);
  const scene::Episode first = sample_episode(tables, seed, 0);
  const Pose2D map_from_scene = inverse(first.start);
  Robot robot({.scene = name, .seed = first.seed, .start_pose = first.start, .randomization = randomization});

  std::vector<double> ticks;  // [s]
  double last = cpu_seconds();
  robot.runtime().observe([&](const TickView& tick) {
    ticks.push_back(cpu_seconds() - last);
    if (has_scan(tick)) print(tick, map_from_scene * robot.simulation()->true_pose());
    last = cpu_seconds();
  });
  const double began = cpu_seconds();
  int motions = 0;
  int reached = 0;
  for (std::uint32_t i = 0; to_seconds(robot.now()) < seconds; ++i) {
    const Vec2 goal = map_from_scene * sample_episode(tables, seed, i).goal;
    const MoveResult result = robot.wait(robot.move_to(goal.x, goal.y));
    reached += result.success ? 1 : 0;
    ++motions;
    if (!result.success) robot.sleep(1.0);
  }
  std::ranges::sort(ticks);
  std::printf("# %.1f %d %d %.2f %.3f %.3f\n", robot.simulation()->distance_driven(), motions, reached,
              cpu_seconds() - began, 1e3 * ticks[ticks.size() * 99 / 100], 1e3 * ticks.back());
}

}  // namespace

int main(int argc, char** argv) {
  const auto seed = parse_number(argc == 5 ? argv[2] : "");
  const auto seconds = parse_number(argc == 5 ? argv[4] : "");
  if (!seed || !seconds) {
    std::fputs("usage: verify_trajectory SCENE SEED RANDOMIZATION SECONDS\n", stderr);
    return 2;
  }
  drive(argv[1], *seed, argv[3], static_cast<double>(*seconds));
  return 0;
}
