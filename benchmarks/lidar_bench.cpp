// Nanoseconds per ray of the lidar, in a room of 44 boxes where other simulators have been measured too.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "threewe/sim/ray_caster.hpp"

namespace {

using namespace threewe;

constexpr double kRangeMax = 12.0;

// 20 x 15 m: four outer walls, eight inner ones, 32 boxes at random places away from the middle.
scene::Slice room() {
  struct Box {
    double x, y, half_length, half_width;
  };
  std::vector<Box> boxes = {{10, 0, 10, .1},       {10, 15, 10, .1},      {0, 7.5, .1, 7.5},   {20, 7.5, .1, 7.5},
                            {6.5, 2.25, .1, 2.25}, {6.5, 7.5, .1, 1.0},   {6.5, 13, .1, 2.0},  {13.5, 2.5, .1, 2.5},
                            {13.5, 8.5, .1, 1.5},  {13.5, 13.5, .1, 1.5}, {10, 10.5, 2.0, .1}, {10, 4.0, 2.0, .1}};
  std::uint64_t state = 12345;
  const auto random = [&] {
    state = (1103515245ULL * state + 12345) % (1ULL << 31);
    return static_cast<double>(state) / static_cast<double>(1ULL << 31);
  };
  while (boxes.size() < 44) {
    const double x = .7 + random() * 18.6;
    const double y = .7 + random() * 13.6;
    const double half_length = .15 + .35 * random();
    const double half_width = .15 + .35 * random();
    if (std::hypot(x - 10, y - 7.5) > 2.3) boxes.push_back({x, y, half_length, half_width});
  }

  scene::Slice slice;
  for (const auto& [x, y, l, w] : boxes) {
    const Vec2 corners[4] = {{x - l, y - w}, {x + l, y - w}, {x + l, y + w}, {x - l, y + w}};
    for (int i = 0; i < 4; ++i) slice.segments.push_back({corners[i], corners[(i + 1) % 4], -1});
  }
  return slice;
}

const sim::RayCaster& caster() {
  static const sim::RayCaster instance(room(), kRangeMax);
  return instance;
}

// Poses that no box covers.
std::vector<Pose2D> free_poses() {
  const scene::Slice slice = room();
  std::mt19937_64 bits(1);
  std::uniform_real_distribution<double> x(0.5, 19.5);
  std::uniform_real_distribution<double> y(0.5, 14.5);
  std::uniform_real_distribution<double> heading(-3.1, 3.1);
  std::vector<Pose2D> poses;
  while (poses.size() < 1024) {
    const Pose2D pose{x(bits), y(bits), heading(bits)};
    bool covered = false;
    for (std::size_t i = 0; i < slice.segments.size(); i += 4) {
      const Vec2 low = slice.segments[i].a;
      const Vec2 high = slice.segments[i + 1].b;
      covered = covered || (pose.x > low.x && pose.x < high.x && pose.y > low.y && pose.y < high.y);
    }
    if (!covered) poses.push_back(pose);
  }
  return poses;
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
