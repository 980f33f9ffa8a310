// What one scan costs: fitting it to the map, and adding it to the map.
#include <benchmark/benchmark.h>

#include <vector>

#include "slam/scan_matcher.hpp"
#include "threewe/scene/geometry.hpp"
#include "threewe/scene/scene.hpp"

namespace {

using namespace threewe;

// What a lidar sees from a pose in office_v2.
std::vector<map::Beam> look(const scene::Slice& slice, const Pose2D& pose) {
  std::vector<map::Beam> beams;
  for (int i = 0; i < 360; ++i) {
    const double angle = i * exact::kPi / 180.0;
    const auto [s, c] = exact::sincos(angle);
    const double range = scene::cast_ray(slice, pose.position(), pose.theta + angle, 12.0);
    beams.push_back({{}, {c, s}, range, range < 12.0});
  }
  return beams;
}

std::vector<map::Beam> in_map(std::vector<map::Beam> beams, const Pose2D& pose) {
  for (map::Beam& b : beams) {
    b.origin = pose * b.origin;
    b.direction = rotate(b.direction, pose.theta);
  }
  return beams;
}

// A map of what is seen on the first metres of a drive.
map::LogOddsMap first_map(const scene::Slice& slice) {
  map::LogOddsMap map;
  for (int i = 0; i < 30; ++i) {
    const Pose2D pose{0.08 * i, 0.0, 0.02 * i};
    map.insert(in_map(look(slice, pose), pose));
  }
  return map;
}

void BM_match_scan(benchmark::State& state) {
  const scene::Slice slice = scene::Scene::load("office_v2").at_height(0.135);
  const map::LogOddsMap map = first_map(slice);
  const Pose2D pose{1.23, 0.0, 0.31};
  const std::vector<map::Beam> beams = look(slice, pose);
  const Pose2D guess{pose.x + 0.004, pose.y - 0.003, pose.theta + 0.002};
  const slam::Matrix4 prior = slam::Vector4{4e4, 4e4, 1e6, 4e3}.asDiagonal();
  for (auto _ : state) benchmark::DoNotOptimize(slam::match_scan(map, beams, {guess, 0.0}, prior, guess));
}
BENCHMARK(BM_match_scan)->Unit(benchmark::kMicrosecond);

void BM_search_pose(benchmark::State& state) {
  const scene::Slice slice = scene::Scene::load("office_v2").at_height(0.135);
  const map::LogOddsMap map = first_map(slice);
  const std::vector<map::Beam> beams = look(slice, {1.23, 0.0, 0.31});
  for (auto _ : state) benchmark::DoNotOptimize(slam::search_pose(map, beams, {1.1, 0.1, 0.2}, {}));
}
BENCHMARK(BM_search_pose)->Unit(benchmark::kMicrosecond);

void BM_insert_scan(benchmark::State& state) {
  const scene::Slice slice = scene::Scene::load("office_v2").at_height(0.135);
  map::LogOddsMap map = first_map(slice);
  const Pose2D pose{1.23, 0.0, 0.31};
  const std::vector<map::Beam> beams = in_map(look(slice, pose), pose);
  for (auto _ : state) map.insert(beams);
}
BENCHMARK(BM_insert_scan)->Unit(benchmark::kMicrosecond);

}  // namespace
