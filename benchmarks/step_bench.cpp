// The simulator's tick: two steps of physics, with and without sensors, and a whole tick of the mock backend.
//
// A robot drives through the office with a new random command every half second, hits what it hits, and begins again
// from the same state every ten seconds.
#include <benchmark/benchmark.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "threewe/backend/registry.hpp"
#include "threewe/core/rng.hpp"
#include "threewe/scene/scene.hpp"
#include "threewe/scene/truth_view.hpp"
#include "threewe/sim/step.hpp"

namespace {

using namespace threewe;

constexpr std::uint64_t kTicks = 500;

std::vector<Velocity> commands(std::uint64_t world) {
  const RngKey key{.seed = world};
  std::vector<Velocity> drawn;
  drawn.reserve(kTicks / 25);
  for (std::uint64_t i = 0; i < kTicks / 25; ++i) {
    drawn.push_back({uniform(key, i, 0, -0.2, 0.5), uniform(key, i, 1, -0.3, 0.3), uniform(key, i, 2, -1.0, 1.0)});
  }
  return drawn;
}

void report_ticks(benchmark::State& bench, std::int64_t worlds) {
  const auto ticks = static_cast<double>(bench.iterations() * worlds);
  bench.counters["ticks/s"] = benchmark::Counter(ticks, benchmark::Counter::kIsRate);
  bench.counters["x real time"] = benchmark::Counter(ticks * to_seconds(kControlPeriod), benchmark::Counter::kIsRate);
}

enum class Sensors : std::uint8_t { none, all_but_ultrasonics, all };

void step_worlds(benchmark::State& bench, Sensors sensors, NoiseLevel noise) {
  RobotProfile profile = with_noise(load_profile("3we_standard_v2"), noise);
  if (sensors == Sensors::none) {
    profile.lidar.reset();
    profile.imu.reset();
  }
  if (sensors != Sensors::all) profile.ultrasonics.reset();
  const auto model = sim::make_model(std::make_shared<const scene::Scene>(scene::Scene::load("office_v2")), {profile});
  const auto worlds = static_cast<std::size_t>(bench.range(0));
  std::vector<sim::RobotState> begin;
  std::vector<std::vector<Velocity>> drives;
  for (std::size_t i = 0; i < worlds; ++i) {
    begin.push_back(sim::begin(*model, 0, {}, i));
    drives.push_back(commands(i));
  }
  std::vector<sim::RobotState> states = begin;
  std::vector<Velocity> sent(worlds);
  std::uint64_t tick = 0;
  for ([[maybe_unused]] auto _ : bench) {
    if (tick == kTicks) {
      states = begin;
      tick = 0;
    }
    for (std::size_t i = 0; i < worlds; ++i) sent[i] = drives[i][tick / 25];
    sim::step(*model, states, sent);
    sim::step(*model, states, sent);
    ++tick;
    benchmark::DoNotOptimize(states.data());
  }
  report_ticks(bench, bench.range(0));
}

void BM_tick_sensorless(benchmark::State& bench) { step_worlds(bench, Sensors::none, NoiseLevel::realistic); }
void BM_tick_ideal_sensors(benchmark::State& bench) { step_worlds(bench, Sensors::all, NoiseLevel::ideal); }
void BM_tick_realistic_sensors(benchmark::State& bench) { step_worlds(bench, Sensors::all, NoiseLevel::realistic); }
void BM_tick_without_ultrasonics(benchmark::State& bench) {
  step_worlds(bench, Sensors::all_but_ultrasonics, NoiseLevel::realistic);
}
BENCHMARK(BM_tick_sensorless)->Arg(1)->Arg(64);
BENCHMARK(BM_tick_ideal_sensors)->Arg(1);
BENCHMARK(BM_tick_realistic_sensors)->Arg(1);
BENCHMARK(BM_tick_without_ultrasonics)->Arg(1);

// As a runtime uses it: a command, time, and every sample polled.
void BM_mock_world_tick(benchmark::State& bench) {
  const auto world = backend::make_world("mock", {});
  backend::RobotPort& robot = world->robot(0);
  robot.connect();
  const auto drive = commands(0);
  std::uint64_t tick = 0;
  for ([[maybe_unused]] auto _ : bench) {
    if (tick == kTicks) {
      world->reset({});
      tick = 0;
    }
    robot.command(drive[tick / 25], world->now() + 200ms);
    world->advance_to(world->now() + kControlPeriod);
    benchmark::DoNotOptimize(robot.poll());
    ++tick;
  }
  report_ticks(bench, 1);
}
BENCHMARK(BM_mock_world_tick);

}  // namespace
