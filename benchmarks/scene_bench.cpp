// What it costs to load a scene, to prepare it for a robot, and to ask it questions.
#include <benchmark/benchmark.h>

#include <memory>

#include "scene/coverage.hpp"
#include "scene/episodes.hpp"
#include "scene/scene_tables.hpp"

namespace threewe::scene {
namespace {

constexpr double kRobotHeight = 0.15;   // [m]
constexpr double kLidarHeight = 0.135;  // [m]

std::shared_ptr<const Scene> office() {
  static const auto scene = std::make_shared<const Scene>(Scene::load("office_v2"));
  return scene;
}

std::shared_ptr<const SceneTables> office_tables() {
  static const auto tables =
      std::make_shared<const SceneTables>(office(), Footprint::rectangle(0.25, 0.22), kRobotHeight);
  return tables;
}

void load_office(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(Scene::load("office_v2"));
}
BENCHMARK(load_office)->Unit(benchmark::kMillisecond);

void office_tables_for_a_robot(benchmark::State& state) {
  for (auto _ : state) {
    benchmark::DoNotOptimize(SceneTables(office(), Footprint::rectangle(0.25, 0.22), kRobotHeight));
  }
}
BENCHMARK(office_tables_for_a_robot)->Unit(benchmark::kMillisecond);

void office_distance_field(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(distance_field(office_tables()->occupied()));
}
BENCHMARK(office_distance_field)->Unit(benchmark::kMillisecond);

void office_geodesic_field(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(office_tables()->geodesic_field({0.0, 0.0}));
}
BENCHMARK(office_geodesic_field)->Unit(benchmark::kMillisecond);

void geodesic_from_a_field(benchmark::State& state) {
  const GeodesicField field = office_tables()->geodesic_field({0.0, 0.0});
  std::uint64_t seed = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(field.length_from(office_tables()->sample_free_pose(++seed).position()));
  }
}
BENCHMARK(geodesic_from_a_field);

void sample_office_episode(benchmark::State& state) {
  std::uint32_t index = 0;
  for (auto _ : state) benchmark::DoNotOptimize(sample_episode(*office_tables(), 1, ++index));
}
BENCHMARK(sample_office_episode)->Unit(benchmark::kMillisecond);

void collision_of_a_footprint(benchmark::State& state) {
  std::uint64_t seed = 0;
  for (auto _ : state) benchmark::DoNotOptimize(office_tables()->collides(office_tables()->sample_free_pose(++seed)));
}
BENCHMARK(collision_of_a_footprint);

void coverage_observation(benchmark::State& state) {
  CoverageMeter meter(office_tables(), kLidarHeight);
  std::uint64_t seed = 0;
  for (auto _ : state) meter.observe(office_tables()->sample_free_pose(++seed));
}
BENCHMARK(coverage_observation)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace threewe::scene
