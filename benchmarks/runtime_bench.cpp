// The whole stack, tick by tick, in the office with realistic noise: how many times faster than real time it runs.
// What is wanted on one core stands beside it.
#include <benchmark/benchmark.h>

#include "threewe/backend/registry.hpp"
#include "threewe/threewe.hpp"

using namespace threewe;

namespace {

constexpr Duration kSlice = 1s;  // of robot time between two readings of the clock

// `wanted`: times real time; 0: nothing.
void report(benchmark::State& state, double wanted) {
  if (wanted > 0.0) state.counters["wanted"] = benchmark::Counter(wanted);
  state.counters["times_real_time"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * to_seconds(kSlice), benchmark::Counter::kIsRate);
  state.counters["ticks_per_second"] = benchmark::Counter(
      static_cast<double>(state.iterations()) * (kSlice / kControlPeriod), benchmark::Counter::kIsRate);
}

// Back and forth on a figure of eight, so that it can go on for ever in the free space around the start.
Velocity figure_of_eight(Time now) {
  const bool left = now / 8s % 2 == 0;
  return {0.2, 0.0, left ? 0.785 : -0.785};
}

// The backend as a runtime uses it, without one.
void simulation_alone(benchmark::State& state) {
  const auto world = backend::make_world("mock", {});
  backend::RobotPort& port = world->robot(0);
  port.connect();
  for (auto _ : state) {
    for (Duration t{}; t < kSlice; t += kControlPeriod) {
      const Time now = world->now();
      port.command(figure_of_eight(now), now + 200ms);
      world->advance_to(now + kControlPeriod);
      benchmark::DoNotOptimize(port.poll());
    }
  }
  report(state, 300.0);
}

// Simulator, localisation, mapping, gate, runtime.
void driven_by_hand(benchmark::State& state) {
  Robot robot;
  for (auto _ : state) {
    for (Duration t{}; t < kSlice; t += 200ms) {
      const Velocity v = figure_of_eight(robot.world().now());
      robot.set_velocity(v.vx, v.vy, v.omega);
      robot.sleep(0.2);
    }
  }
  report(state, 100.0);
}

// The same with planning and control: exploring, begun anew when there is nothing left to see.
void exploring(benchmark::State& state) {
  Robot robot;
  ExplorationHandle exploration = robot.explore();
  for (auto _ : state) {
    robot.sleep(to_seconds(kSlice));
    if (!exploration.motion->done()) continue;
    state.PauseTiming();
    robot.simulation()->reset(0);
    exploration = robot.explore();
    state.ResumeTiming();
  }
  report(state, 0.0);
}

}  // namespace

BENCHMARK(simulation_alone)->Unit(benchmark::kMillisecond);
BENCHMARK(driven_by_hand)->Unit(benchmark::kMillisecond);
BENCHMARK(exploring)->Unit(benchmark::kMillisecond);
