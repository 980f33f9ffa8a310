// What a place that no program has seen costs: drawing it, and the tables of a robot in it.
#include "threewe/scene/generator.hpp"

#include <benchmark/benchmark.h>

#include <memory>

#include "scene/scene_tables.hpp"

namespace threewe::scene {
namespace {

constexpr double kRobotHeight = 0.15;  // [m]

// Every iteration draws another scene; the argument is the difficulty in percent.
GeneratorOptions options(const benchmark::State& state) {
  return {.difficulty = static_cast<double>(state.range(0)) / 100.0};
}

void generate_scene(benchmark::State& state) {
  std::uint64_t seed = 0;
  for (auto _ : state) benchmark::DoNotOptimize(generate(++seed, options(state)));
}
BENCHMARK(generate_scene)->Arg(0)->Arg(50)->Arg(100)->Unit(benchmark::kMillisecond);

void generate_scene_with_tables(benchmark::State& state) {
  std::uint64_t seed = 0;
  for (auto _ : state) {
    const auto scene = std::make_shared<const Scene>(generate(++seed, options(state)));
    benchmark::DoNotOptimize(SceneTables(scene, Footprint::rectangle(0.25, 0.22), kRobotHeight));
  }
}
BENCHMARK(generate_scene_with_tables)->Arg(0)->Arg(50)->Arg(100)->Unit(benchmark::kMillisecond);

void write_scene(benchmark::State& state) {
  const Scene scene = generate(1);
  for (auto _ : state) benchmark::DoNotOptimize(to_yaml(scene));
}
BENCHMARK(write_scene)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace threewe::scene
