// Planning over office_v2, 20 x 15 m in cells of 5 cm, once it is known; and over 200 m x 200 m of furnished buildings.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <queue>
#include <random>
#include <utility>
#include <vector>

#include "core/exact.hpp"
#include "core/grid_line.hpp"
#include "course.hpp"
#include "map/change_log.hpp"
#include "map/log_odds_map.hpp"
#include "nav/frontiers.hpp"
#include "nav/planner.hpp"
#include "threewe/scene/scene.hpp"
#include "threewe/scene/solid.hpp"

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
  for (auto _ : state) nav::find_frontiers(costmap, {}, size_of);
}
BENCHMARK(BM_frontiers)->Unit(benchmark::kMicrosecond);

// What Dijkstra's search finds over a dense neighbourhood: straight lines to every cell within 4 cells, 48 directions,
// each costing the weights under it, exactly. An admissible heuristic (A*) spares it most of the map and changes no
// cost.
double dense_cost(const map::Costmap& costmap, map::Cell start, map::Cell goal) {
  struct Line {
    map::Cell to;
    std::vector<std::pair<map::Cell, double>> under;  // cells, and how much of the line [cells] lies in each
  };
  static const std::vector<Line> lines = [] {
    constexpr int kPieces = 20'000;
    std::vector<Line> all;
    for (int y = -4; y <= 4; ++y) {
      for (int x = -4; x <= 4; ++x) {
        if (std::gcd(x, y) != 1) continue;
        Line line{{x, y}, {}};
        const double piece = std::hypot(x, y) / kPieces;
        for (int i = 0; i < kPieces; ++i) {
          const double t = (i + 0.5) / kPieces;
          const map::Cell c{static_cast<int>(std::floor(0.5 + t * x)), static_cast<int>(std::floor(0.5 + t * y))};
          if (line.under.empty() || line.under.back().first != c) line.under.emplace_back(c, 0.0);
          line.under.back().second += piece;
        }
        all.push_back(line);
      }
    }
    return all;
  }();
  const auto least = [&](map::Cell c) { return map::Costmap::kFree * std::hypot(c.x - goal.x, c.y - goal.y); };
  std::vector<double> costs(costmap.weights().size(), 1e300);
  std::vector<bool> settled(costs.size());
  using Entry = std::pair<double, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  costs[costmap.index(start)] = 0.0;
  queue.emplace(least(start), costmap.index(start));
  const auto width = static_cast<std::size_t>(costmap.width());
  while (!queue.empty()) {
    const std::size_t index = queue.top().second;
    queue.pop();
    if (settled[index]) continue;
    settled[index] = true;
    const map::Cell here{static_cast<int>(index % width), static_cast<int>(index / width)};
    if (here == goal) break;
    for (const Line& line : lines) {
      double cost = costs[index];
      for (const auto& [c, length] : line.under) {
        const map::Costmap::Weight w = costmap.weight({here.x + c.x, here.y + c.y});
        cost += w == map::Costmap::kLethal ? 1e300 : w * length;
      }
      const map::Cell there{here.x + line.to.x, here.y + line.to.y};
      if (!costmap.contains(there) || cost >= costs[costmap.index(there)]) continue;
      costs[costmap.index(there)] = cost;
      queue.emplace(cost + least(there), costmap.index(there));
    }
  }
  return costs[costmap.index(goal)] * costmap.resolution();
}

// The course, and what Dijkstra finds between each start and goal [m times weight].
struct PricedCourse : Course {
  std::vector<double> least;

  PricedCourse() : Course(campus()) {
    for (const Journey& j : journeys) least.push_back(dense_cost(costmap, costmap.cell(j.from), costmap.cell(j.to)));
  }
};

const PricedCourse& course() {
  static const PricedCourse all;
  return all;
}

double milliseconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

// All journeys, one after the other; tables of tiles are kept, as they are while the costmap stays as it is.
void BM_plan_75_m(benchmark::State& state) {
  const PricedCourse& c = course();
  nav::Planner planner;
  const auto start = std::chrono::steady_clock::now();
  for (const Journey& j : c.journeys) planner.plan(c.costmap, j.from, j.to, 0.25);
  const double first = milliseconds_since(start) / static_cast<double>(c.journeys.size());
  std::vector<double> times;
  std::vector<double> ratios;
  for (auto _ : state) {
    for (std::size_t i = 0; i < c.journeys.size(); ++i) {
      const auto begin = std::chrono::steady_clock::now();
      const nav::PlannedPath path = planner.plan(c.costmap, c.journeys[i].from, c.journeys[i].to, 0.25);
      times.push_back(milliseconds_since(begin));
      ratios.push_back(path.cost / c.least[i]);
    }
  }
  state.counters["median_ms"] = quantile(times, 0.5);
  state.counters["p90_ms"] = quantile(times, 0.9);
  state.counters["max_ms"] = quantile(times, 1.0);
  state.counters["first_ms"] = first;
  state.counters["cost_median"] = quantile(ratios, 0.5);
  state.counters["cost_max"] = quantile(ratios, 1.0);
  state.counters["MB"] = 1e-6 * static_cast<double>(planner.graph().memory());
}
BENCHMARK(BM_plan_75_m)->Unit(benchmark::kMillisecond)->Iterations(3);

// A scan of 450 beams from the start of a journey, off by up to 6 cm: what is hit counts as occupied until the next.
std::vector<Vec2> scan(const map::OccupancyGrid& grid, Vec2 from, std::mt19937_64& bits) {
  std::vector<Vec2> hits;
  for (int i = 0; i < 450; ++i) {
    const auto [s, c] = exact::sincos(i * exact::kPi / 225.0);
    const Vec2 end = from + 12.0 * Vec2{c, s};
    const double cells = 1.0 / grid.resolution;
    map::Cell hit{-1, -1};
    walk_grid_line(cells * (from - grid.origin), cells * (end - grid.origin), [&](int x, int y) {
      if (grid.at({x, y}) == map::OccupancyGrid::kOccupied) hit = {x, y};
      return hit.x < 0;
    });
    const double off = 0.12 * static_cast<double>(bits() % 1000) / 1000.0 - 0.06;
    if (hit.x >= 0) hits.push_back(grid.center(hit) + off * Vec2{c, s});
  }
  return hits;
}

// The costmap takes over the next scan, then the same journey is planned again.
void BM_replan_75_m(benchmark::State& state) {
  const PricedCourse& c = course();
  nav::Planner planner;
  std::mt19937_64 bits(7);
  map::Costmap costmap;
  costmap.update(c.grid, {}, {});
  std::vector<double> updates;
  std::vector<double> plans;
  std::size_t tables = 0;
  for (auto _ : state) {
    for (const Journey& j : c.journeys) {
      planner.plan(costmap, j.from, j.to, 0.25);
      for (int i = 0; i < 3; ++i) {
        const std::vector<Vec2> seen = scan(c.grid, j.from, bits);
        const auto begin = std::chrono::steady_clock::now();
        costmap.update(c.grid, seen, {}, 20, map::Region{});
        updates.push_back(milliseconds_since(begin));
        const std::size_t before = planner.graph().tables_made();
        const auto planned = std::chrono::steady_clock::now();
        planner.plan(costmap, j.from, j.to, 0.25);
        plans.push_back(milliseconds_since(planned));
        tables += planner.graph().tables_made() - before;
      }
    }
  }
  state.counters["update_ms"] = quantile(updates, 0.5);
  state.counters["plan_ms"] = quantile(plans, 0.5);
  state.counters["plan_max_ms"] = quantile(plans, 1.0);
  state.counters["tables"] = static_cast<double>(tables) / static_cast<double>(plans.size());
}
BENCHMARK(BM_replan_75_m)->Unit(benchmark::kMillisecond)->Iterations(1);

}  // namespace
