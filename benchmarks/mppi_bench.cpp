// A tick of model predictive path integral control as robots drive with it, in a furnished room, all critics on: every
// fifth tick makes a plan of prediction, path, noise, rollouts of 56 steps and update; the others follow it. The
// obstacle field is made once per scan, so every fifth tick here has a new one. More samples are for comparison.
#include <benchmark/benchmark.h>

#include <string>
#include <vector>

#include "control_room.hpp"
#include "hardware/parameters.hpp"
#include "nav/mppi.hpp"

namespace {

using namespace threewe;

void run(benchmark::State& state, const std::string& robot, bool new_scans) {
  const RobotProfile profile = load_profile(robot);
  auto params = params_for<nav::Params>(profile, "nav");
  params.mppi.samples = static_cast<int>(state.range(0));
  nav::Mppi mppi(profile, params);
  const std::vector<Vec2> scans[2] = {scan_of_a_room(0.0), scan_of_a_room(0.003)};
  const std::vector<nav::MovingDisc> people = {{{1.5, 1.5}, {-0.3, -0.5}}, {{-1.0, 1.0}, {0.5, 0.0}}};
  Velocity command;
  int tick = 0;
  for (auto _ : state) {
    const std::size_t scan = new_scans ? static_cast<std::size_t>(tick / 5 % 2) : 0;
    command = mppi.step({tick++ * kControlPeriod, {0.0, 0.02, 0.1}, command, scans[scan], people},
                        {.path = kPathThroughADoor, .margin = 0.05});
    benchmark::DoNotOptimize(command);
  }
  state.counters["samples"] = benchmark::Counter(static_cast<double>(params.mppi.samples));
}

void BM_mppi_tick(benchmark::State& state) { run(state, "3we_standard_v2", false); }
void BM_mppi_tick_differential(benchmark::State& state) { run(state, "turtlebot_like", false); }
void BM_mppi_tick_with_scans(benchmark::State& state) { run(state, "3we_standard_v2", true); }
BENCHMARK(BM_mppi_tick)->Arg(512)->Arg(2000)->Arg(8000)->Unit(benchmark::kMicrosecond);
BENCHMARK(BM_mppi_tick_differential)->Arg(512)->Unit(benchmark::kMicrosecond);
BENCHMARK(BM_mppi_tick_with_scans)->Arg(512)->Unit(benchmark::kMicrosecond);

}  // namespace
