// Nanoseconds per ray of the lidar, in a room of 44 boxes where other simulators have been measured too.
#include <benchmark/benchmark.h>

#include <random>
#include <vector>

#include "core/exact.hpp"
#include "lidar_room.hpp"
#include "scene/obstacles.hpp"
#include "sim/ray_caster.hpp"
#include "threewe/scene/scene.hpp"

namespace {

using namespace threewe;
using namespace threewe::benchmarks;

const sim::RayCaster& caster() {
  static const sim::RayCaster instance(room(), kRangeMax);
  return instance;
}

void report(benchmark::State& state, double rays) {
  state.counters["per_ray"] = benchmark::Counter(rays * static_cast<double>(state.iterations()),
                                                 benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

// One turn from one pose.
void one_pose(benchmark::State& state) {
  const auto poses = free_poses();
  const auto beams = static_cast<std::size_t>(state.range(0));
  std::vector<float> ranges(beams);
  std::size_t i = 0;
  for (auto _ : state) {
    caster().cast(poses[i++ % poses.size()], -exact::kPi, 2 * exact::kPi / static_cast<double>(beams), ranges);
    benchmark::DoNotOptimize(ranges.data());
  }
  report(state, static_cast<double>(beams));
}
BENCHMARK(one_pose)->Arg(64)->Arg(360)->Arg(450);

// One turn each from 1,024 places of an office, where chairs and tables have legs: so is a batch of environments.
void office(benchmark::State& state) {
  static const scene::Scene scene = scene::Scene::load("office_v2");
  static const sim::RayCaster seeing(scene.at_height(0.135), kRangeMax);
  const scene::Obstacles obstacles(scene.solids());
  std::mt19937_64 bits(1);
  std::uniform_real_distribution<double> x(scene.min.x, scene.max.x);
  std::uniform_real_distribution<double> y(scene.min.y, scene.max.y);
  std::uniform_real_distribution<double> heading(-3.1, 3.1);
  std::vector<Pose2D> poses;
  while (poses.size() < 1024) {
    const Pose2D pose{x(bits), y(bits), heading(bits)};
    if (scene.room_at(pose.position()) && obstacles.clearance(pose.position()) > 0.15) poses.push_back(pose);
  }

  const auto beams = static_cast<std::size_t>(state.range(0));
  std::vector<float> ranges(beams);
  std::size_t i = 0;
  for (auto _ : state) {
    seeing.cast(poses[i++ % poses.size()], -exact::kPi, 2 * exact::kPi / static_cast<double>(beams), ranges);
    benchmark::DoNotOptimize(ranges.data());
  }
  report(state, static_cast<double>(beams));
}
BENCHMARK(office)->Arg(64)->Arg(360);

// One turn on the way, as a clockwise lidar delivers it: a tenth of it in each of ten steps.
void rolling(benchmark::State& state) {
  const auto poses = free_poses();
  const auto beams = static_cast<std::size_t>(state.range(0));
  const double increment = -2 * exact::kPi / static_cast<double>(beams);
  std::vector<float> ranges(beams / 10);
  std::size_t i = 0;
  for (auto _ : state) {
    Pose2D pose = poses[i++ % poses.size()];
    for (int step = 0; step < 10; ++step) {
      const Pose2D next = integrate(pose, {0.5, 0.1, 0.5}, 0.01);
      const double angle_min = increment * static_cast<double>(step) * static_cast<double>(ranges.size());
      caster().cast_rolling(pose, next, angle_min, increment, ranges);
      benchmark::DoNotOptimize(ranges.data());
      pose = next;
    }
  }
  report(state, 10.0 * static_cast<double>(ranges.size()));
}
BENCHMARK(rolling)->Arg(360)->Arg(450);

// The slow twin, for scale.
void every_shape(benchmark::State& state) {
  const auto poses = free_poses();
  const scene::Slice slice = room();
  std::size_t i = 0;
  for (auto _ : state) {
    const Pose2D& pose = poses[i++ % poses.size()];
    benchmark::DoNotOptimize(scene::cast_ray(slice, pose.position(), pose.theta, kRangeMax));
  }
  report(state, 1.0);
}
BENCHMARK(every_shape);

// Finding out what can be seen from where.
void build(benchmark::State& state) {
  const scene::Slice slice = room();
  for (auto _ : state) benchmark::DoNotOptimize(sim::RayCaster(slice, kRangeMax));
}
BENCHMARK(build)->Unit(benchmark::kMillisecond);

}  // namespace
