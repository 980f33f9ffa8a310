// What one control tick takes while a robot drives from goal to goal in a place that it has never seen, everything on:
//
//   verify_tick SCENE SEED
//
// A tick is a period of the world and all that the robot makes of it: noise, localising and mapping, the tracker of
// people, planning, control, the gate. Times of this one thread, by its CPU time and by the wall's clock.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <numeric>
#include <vector>

#include "number.hpp"
#include "seconds.hpp"
#include "threewe/robot/robot.hpp"

using namespace threewe;

namespace {

constexpr int kTicks = 10000;

double percentile_99(std::vector<double> values) {
  const auto rank = static_cast<std::ptrdiff_t>(values.size() * 99 / 100);
  std::ranges::nth_element(values, values.begin() + rank);
  return values[static_cast<std::size_t>(rank)];
}

}  // namespace

int main(int argc, char** argv) {
  const auto seed = parse_number(argc == 3 ? argv[2] : "");
  if (!seed) {
    std::fputs("usage: verify_tick SCENE SEED\n", stderr);
    return 2;
  }
  Robot robot({.scene = argv[1], .seed = *seed});
  std::uint64_t goals = *seed;
  MotionHandle motion;
  std::vector<double> cpu;
  std::vector<double> wall;
  while (cpu.size() < kTicks) {
    if (!motion || motion->done()) {
      const Pose2D goal = robot.simulation()->sample_free_pose(goals++);
      motion = robot.move_to(goal.x, goal.y);
    }
    const double cpu_before = seconds_by(CLOCK_THREAD_CPUTIME_ID);
    const double wall_before = seconds_by(CLOCK_MONOTONIC);
    robot.sleep(to_seconds(kControlPeriod));
    cpu.push_back(seconds_by(CLOCK_THREAD_CPUTIME_ID) - cpu_before);
    wall.push_back(seconds_by(CLOCK_MONOTONIC) - wall_before);
  }
  std::printf("cpu_p99_ms %.3f\nwall_p99_ms %.3f\n", 1e3 * percentile_99(cpu), 1e3 * percentile_99(wall));
  std::printf("cpu_worst_ms %.3f\n", 1e3 * *std::ranges::max_element(cpu));
  const auto faster = [](const std::vector<double>& ticks) {
    return kTicks * to_seconds(kControlPeriod) / std::accumulate(ticks.begin(), ticks.end(), 0.0);
  };
  std::printf("cpu_times %.1f\nwall_times %.1f\n", faster(cpu), faster(wall));
  std::printf("metres %.1f\n", robot.simulation()->distance_driven());
}
