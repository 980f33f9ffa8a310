// Planning over office_v2, 20 x 15 m in cells of 5 cm, once it is known.
#include <benchmark/benchmark.h>

#include <utility>
#include <vector>

#include "threewe/map/log_odds_map.hpp"
#include "threewe/nav/frontiers.hpp"
#include "threewe/nav/planner.hpp"
#include "threewe/scene/geometry.hpp"
#include "threewe/scene/scene.hpp"

namespace {

using namespace threewe;

// A map of the whole office, of scans taken at the anchors of its rooms.
map::OccupancyGrid office() {
  const scene::Scene scene = scene::Scene::load("office_v2");
  const scene::Slice slice = scene.at_height(0.135);
  map::LogOddsMap map({.free_range = 12.0});
  for (const scene::Room& room : scene.rooms) {
    std::vector<map::Beam> beams;
    for (int i = 0; i < 1440; ++i) {
      const auto [s, c] = exact::sincos(i * exact::kPi / 720.0);
      const double range = scene::cast_ray(slice, room.anchor, i * exact::kPi / 720.0, 12.0);
      beams.push_back({room.anchor, {c, s}, range, range < 12.0});
    }
    map.insert(beams);
  }
  return map.grid();
}

// The two anchors that are farthest from each other.
std::pair<Vec2, Vec2> far_apart() {
  const scene::Scene scene = scene::Scene::load("office_v2");
  std::pair<Vec2, Vec2> best;
  double most = 0.0;
  for (const scene::Room& a : scene.rooms) {
    for (const scene::Room& b : scene.rooms) {
      if (distance(a.anchor, b.anchor) > most) most = distance(a.anchor, b.anchor), best = {a.anchor, b.anchor};
    }
  }
  return best;
}

void BM_costmap(benchmark::State& state) {
  const map::OccupancyGrid grid = office();
  map::Costmap costmap;
  for (auto _ : state) costmap.update(grid, {}, {});
}
BENCHMARK(BM_costmap)->Unit(benchmark::kMicrosecond);

void BM_astar(benchmark::State& state) {
  map::Costmap costmap;
  costmap.update(office(), {}, {});
  const auto [from, to] = far_apart();
  nav::GridSearch search;
  for (auto _ : state) {
    benchmark::DoNotOptimize(search.to_cell(costmap, costmap.cell(from), costmap.cell(to)));
  }
}
BENCHMARK(BM_astar)->Unit(benchmark::kMicrosecond);

void BM_plan(benchmark::State& state) {
  map::Costmap costmap;
  costmap.update(office(), {}, {});
  const auto [from, to] = far_apart();
  nav::Planner planner;
  double length = 0.0;
  for (auto _ : state) {
    const nav::PlannedPath path = planner.plan(costmap, from, to, 0.25);
    length = nav::path_length(path.points);
  }
  state.counters["metres"] = length;
}
BENCHMARK(BM_plan)->Unit(benchmark::kMicrosecond);

void BM_frontiers(benchmark::State& state) {
  map::Costmap costmap;
  costmap.update(office(), {}, {});
  std::vector<std::uint16_t> size_of;
  for (auto _ : state) nav::find_frontiers(costmap, size_of);
}
BENCHMARK(BM_frontiers)->Unit(benchmark::kMicrosecond);

}  // namespace
