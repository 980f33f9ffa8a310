// The simulator's tick: two steps of physics, with and without sensors, and a whole tick of the mock backend.
//
// A robot drives through the office with a new random command every half second, hits what it hits, and begins again
// from the same state every ten seconds: from the scene's start, in a large room, or from anywhere, where after a while
// one in five leans against something.
#include <benchmark/benchmark.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "core/rng.hpp"
#include "scene/episodes.hpp"
#include "scene/scene_tables.hpp"
#include "sim/step.hpp"
#include "threewe/backend/registry.hpp"
#include "threewe/scene/scene.hpp"
#include "threewe/scene/truth_view.hpp"

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

enum class From : std::uint8_t { start, anywhere };

struct Kind {
  NoiseLevel noise = NoiseLevel::realistic;
  sim::Sensing sensing;
  From from = From::start;
};

constexpr sim::Sensing kNone{.lidar = false, .imu = false, .odometry = false, .ultrasonics = false};
constexpr sim::Sensing kOdometry{.lidar = false, .imu = false, .odometry = true, .ultrasonics = false};
constexpr sim::Sensing kAll{};
constexpr sim::Sensing kAllButUltrasonics{.ultrasonics = false};

void step_worlds(benchmark::State& bench, const Kind& kind) {
  const RobotProfile profile = with_noise(load_profile("3we_standard_v2"), kind.noise);
  const auto office = std::make_shared<const scene::Scene>(scene::Scene::load("office_v2"));
  const auto model = sim::make_model(office, {profile});
  const scene::SceneTables tables(office, profile.body.footprint, profile.body.height);
  const auto count = static_cast<std::size_t>(bench.range(0));
  std::vector<sim::RobotState> begin;
  std::vector<std::vector<Velocity>> drives;
  for (std::size_t i = 0; i < count; ++i) {
    const RngKey key{.seed = i, .stream = Stream::sampler};
    const Pose2D pose = kind.from == From::start ? Pose2D{} : scene::sample_roomy_pose(tables, key, 0);
    begin.push_back(sim::begin(*model, 0, pose, i));
    drives.push_back(commands(i));
  }
  std::vector<sim::RobotState> states = begin;
  std::vector<Velocity> sent(count);
  std::vector<sim::World> worlds;
  for (std::size_t i = 0; i < count; ++i) {
    worlds.push_back({model.get(), {&states[i], 1}, {&sent[i], 1}, {}, kind.sensing});
  }
  std::uint64_t tick = 0;
  for ([[maybe_unused]] auto _ : bench) {
    if (tick == kTicks) {
      bench.PauseTiming();
      states = begin;
      tick = 0;
      bench.ResumeTiming();
    }
    for (std::size_t i = 0; i < count; ++i) sent[i] = drives[i][tick / 25];
    sim::step(worlds, 2);
    ++tick;
    benchmark::DoNotOptimize(states.data());
  }
  report_ticks(bench, bench.range(0));
}

void BM_tick_sensorless(benchmark::State& bench) { step_worlds(bench, {.sensing = kNone}); }
void BM_tick_with_odometry(benchmark::State& bench) { step_worlds(bench, {.sensing = kOdometry}); }
void BM_tick_sensorless_anywhere(benchmark::State& bench) {
  step_worlds(bench, {.sensing = kNone, .from = From::anywhere});
}
void BM_tick_ideal_sensors(benchmark::State& bench) {
  step_worlds(bench, {.noise = NoiseLevel::ideal, .sensing = kAll});
}
void BM_tick_realistic_sensors(benchmark::State& bench) { step_worlds(bench, {.sensing = kAll}); }
void BM_tick_without_ultrasonics(benchmark::State& bench) { step_worlds(bench, {.sensing = kAllButUltrasonics}); }
BENCHMARK(BM_tick_sensorless)->Arg(1)->Arg(64)->Arg(1024);
BENCHMARK(BM_tick_with_odometry)->Arg(1)->Arg(1024);
BENCHMARK(BM_tick_sensorless_anywhere)->Arg(1024);
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
