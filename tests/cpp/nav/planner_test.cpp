// Ways through tiles against Dijkstra over cells: they exist where paths do, cost hardly more, and do not depend on
// what was planned before.
#include "nav/planner.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>
#include <queue>
#include <random>
#include <utility>
#include <vector>

#include "draw.hpp"
#include "nav/random_costmap.hpp"
#include "nav/tile_walk.hpp"

namespace threewe::nav {
namespace {

using map::Cell;
using map::Costmap;
using map::OccupancyGrid;
using testing::random_cell;
using testing::random_costmap;
using testing::random_free_cell;
using testing::random_grid;

constexpr std::uint64_t kNever = std::numeric_limits<std::uint64_t>::max();

// The weights under a step to one of 16 neighbours, times 256 of its length; nothing where it meets a lethal cell.
std::optional<std::uint64_t> step_cost(const Costmap& costmap, Cell start, Cell a, Cell b) {
  const int dx = b.x - a.x;
  const int dy = b.y - a.y;
  std::vector<Cell> cells = {a, b};
  std::uint64_t factor = dx * dy == 0 ? 128 : 181;
  if (std::abs(dx * dy) == 2) {
    const int sx = dx > 0 ? 1 : -1;
    const int sy = dy > 0 ? 1 : -1;
    cells.push_back(std::abs(dx) == 2 ? Cell{a.x + sx, a.y} : Cell{a.x, a.y + sy});
    cells.push_back({a.x + sx, a.y + sy});
    factor = 143;
  }
  std::uint64_t sum = 0;
  for (const Cell c : cells) {
    if (!costmap.contains(c)) return {};
    const Costmap::Weight w = c == start ? std::min<Costmap::Weight>(costmap.weight(c), 100) : costmap.weight(c);
    if (w == Costmap::kLethal) return {};
    sum += w;
  }
  return factor * sum;
}

// By the book, over steps no longer than `reach` cells.
std::vector<std::uint64_t> dijkstra(const Costmap& costmap, Cell start, int reach) {
  std::vector<std::uint64_t> cost(costmap.weights().size(), kNever);
  using Entry = std::pair<std::uint64_t, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  cost[costmap.index(start)] = 0;
  queue.emplace(0, costmap.index(start));
  while (!queue.empty()) {
    const auto [c, index] = queue.top();
    queue.pop();
    if (c > cost[index]) continue;
    const auto width = static_cast<std::size_t>(costmap.width());
    const Cell here{static_cast<int>(index % width), static_cast<int>(index / width)};
    for (int dy = -reach; dy <= reach; ++dy) {
      for (int dx = -reach; dx <= reach; ++dx) {
        const int squared = dx * dx + dy * dy;
        if (squared != 1 && squared != 2 && squared != 5) continue;
        const Cell there{here.x + dx, here.y + dy};
        const std::optional<std::uint64_t> step = step_cost(costmap, start, here, there);
        if (!step || c + *step >= cost[costmap.index(there)]) continue;
        cost[costmap.index(there)] = c + *step;
        queue.emplace(c + *step, costmap.index(there));
      }
    }
  }
  return cost;
}

// What a path of cells costs; it must be one.
std::uint64_t cost_of(const Costmap& costmap, const std::vector<Cell>& path) {
  std::uint64_t sum = 0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    const std::optional<std::uint64_t> step = step_cost(costmap, path.front(), path[i - 1], path[i]);
    REQUIRE(step);
    sum += *step;
  }
  return sum;
}

TEST_CASE("there is a way through tiles exactly where there is a path, and it costs hardly more than the cheapest") {
  std::uint64_t found = 0;
  std::uint64_t none = 0;
  double sum = 0.0;
  double worst = 1.0;
  for (std::uint64_t seed = 0; seed < cases(2000); ++seed) {
    CAPTURE(seed);
    std::mt19937_64 bits(seed);
    const Costmap costmap = random_costmap(bits, 110);
    const Cell start = random_cell(costmap, bits);  // may be lethal
    const Cell goal = random_free_cell(costmap, bits);
    if (costmap.weight(goal) == Costmap::kLethal) continue;
    TileGraph graph;
    const std::optional<TileWay> way = graph.find(costmap, start, goal);
    REQUIRE(way.has_value() == (start == goal || dijkstra(costmap, start, 1)[costmap.index(goal)] != kNever));
    ++(way ? found : none);
    if (!way) continue;

    const std::vector<Cell> path = walk_tiles(costmap, *way, start, goal);
    REQUIRE(path.front() == start);
    REQUIRE(path.back() == goal);
    const std::uint64_t cost = cost_of(costmap, path);
    const std::uint64_t least = dijkstra(costmap, start, 2)[costmap.index(goal)];
    REQUIRE(cost >= least);
    REQUIRE(cost <= way->cost);
    if (least == 0) continue;
    const double ratio = static_cast<double>(cost) / static_cast<double>(least);
    sum += ratio - 1.0;
    worst = std::max(worst, ratio);
  }
  MESSAGE("dearer than the cheapest by ", 100.0 * sum / static_cast<double>(found), " % on average, ",
          100.0 * (worst - 1.0), " % at most");
  CHECK(found > cases(500));
  CHECK(none > cases(200));
  CHECK(sum / static_cast<double>(found) < 0.01);
  CHECK(worst < 1.2);
}

TEST_CASE("after a search in vain it is known what else can be reached") {
  std::uint64_t reached = 0;
  std::uint64_t out_of_reach = 0;
  for (std::uint64_t seed = 0; seed < cases(1500); ++seed) {
    CAPTURE(seed);
    std::mt19937_64 bits(seed);
    const Costmap costmap = random_costmap(bits, 110);
    const Cell start = random_cell(costmap, bits);
    const Cell goal = random_free_cell(costmap, bits);
    TileGraph graph;
    if (costmap.weight(goal) == Costmap::kLethal || graph.find(costmap, start, goal)) continue;
    const std::vector<std::uint64_t> costs = dijkstra(costmap, start, 1);
    for (int i = 0; i < 10; ++i) {
      const Cell c = random_free_cell(costmap, bits);
      if (c == start || costmap.weight(c) == Costmap::kLethal) continue;
      const bool expected = costs[costmap.index(c)] != kNever;
      REQUIRE(graph.reaches(costmap, c) == expected);
      ++(expected ? reached : out_of_reach);
    }
  }
  CHECK(reached > cases(500));
  CHECK(out_of_reach > cases(500));
}

TEST_CASE("a plan is the same to the bit whatever was planned and changed before, and makes tables only where it was") {
  for (std::uint64_t seed = 0; seed < cases(60); ++seed) {
    CAPTURE(seed);
    std::mt19937_64 bits(seed);
    OccupancyGrid grid = random_grid(bits, 150);
    Costmap costmap;
    Planner planner;
    for (int round = 0; round < 40; ++round) {
      CAPTURE(round);
      // a few things come and go, now and then the frame changes
      for (int i = 0; i < 3; ++i) {
        const map::Cell c{static_cast<int>(bits() % static_cast<unsigned>(grid.width)),
                          static_cast<int>(bits() % static_cast<unsigned>(grid.height))};
        grid.data[grid.index(c)] = bits() % 3 == 0 ? OccupancyGrid::kOccupied : OccupancyGrid::kFree;
      }
      const std::vector<Vec2> include = {{bits() % 10 == 0 ? -6.0 : 0.0, 0.0}};
      costmap.update(grid, {}, include, 0);
      const Vec2 from = costmap.center(random_free_cell(costmap, bits));
      const Vec2 to = costmap.center(random_free_cell(costmap, bits));
      if (bits() % 2 == 0) costmap.open_around(from, 0.2);

      const PlannedPath path = planner.plan(costmap, from, to, 0.1);
      const PlannedPath expected = Planner().plan(costmap, from, to, 0.1);
      REQUIRE(path.points == expected.points);
      REQUIRE(path.cost == expected.cost);
      const std::size_t made = planner.graph().tables_made();
      const PlannedPath again = planner.plan(costmap, from, to, 0.1);
      REQUIRE(again.points == expected.points);
      REQUIRE(planner.graph().tables_made() == made);
    }
  }
}

TEST_CASE("a straightened path costs what the cells do or less, keeps its ends and never meets a lethal cell") {
  std::uint64_t paths = 0;
  for (std::uint64_t seed = 0; seed < cases(1500); ++seed) {
    CAPTURE(seed);
    std::mt19937_64 bits(seed);
    const Costmap costmap = random_costmap(bits);
    const Cell start = random_cell(costmap, bits);
    const Cell goal = random_free_cell(costmap, bits);
    if (costmap.weight(start) == Costmap::kLethal || costmap.weight(goal) == Costmap::kLethal) continue;
    const std::optional<TileWay> way = TileGraph().find(costmap, start, goal);
    if (!way) continue;
    const std::vector<Cell> found = walk_tiles(costmap, *way, start, goal);
    if (found.size() < 3) continue;
    ++paths;

    std::vector<Vec2> cells;
    cells.reserve(found.size());
    for (const Cell c : found) cells.push_back(costmap.center(c));
    const std::vector<Vec2> straight = straighten(costmap, found, cells.front(), cells.back());
    CHECK(straight.front() == cells.front());
    CHECK(straight.back() == cells.back());
    CHECK(straight.size() <= cells.size());
    CHECK(path_cost(costmap, straight) <= 1.02 * path_cost(costmap, cells));  // both are sampled
    CHECK(path_length(straight) <= path_length(cells) + 1e-6);
  }
  CHECK(paths > cases(300));
}

TEST_CASE("a path that begins in a lethal cell goes round walls like any other") {
  OccupancyGrid grid;
  grid.width = 60;
  grid.height = 40;
  grid.data.assign(2400, OccupancyGrid::kFree);
  for (int y = 0; y < 30; ++y) grid.data[grid.index({30, y})] = OccupancyGrid::kOccupied;
  Costmap costmap;
  costmap.update(grid, {}, {});
  Planner planner;
  const Vec2 start = grid.center({28, 10});
  const PlannedPath path = planner.plan(costmap, start, grid.center({50, 10}), 0.1);
  REQUIRE(path.points.size() > 2);
  for (std::size_t i = 1; i < path.points.size(); ++i) {
    const Vec2 a = path.points[i - 1];
    const Vec2 b = path.points[i];
    // every piece that crosses the wall's line does so beyond one of its ends
    if ((a.x < 1.525) != (b.x < 1.525)) CHECK((std::min(a.y, b.y) > 1.5 || std::max(a.y, b.y) < 0.0));
  }
}

TEST_CASE("a goal that is occupied is approached as near as its tolerance allows") {
  OccupancyGrid grid;
  grid.width = grid.height = 60;
  grid.data.assign(3600, OccupancyGrid::kFree);
  grid.data[grid.index({40, 30})] = OccupancyGrid::kOccupied;
  Costmap costmap;
  costmap.update(grid, {}, {});
  Planner planner;
  const Vec2 goal = grid.center({40, 30});
  const PlannedPath path = planner.plan(costmap, {0.5, 1.5}, goal, 0.25);
  REQUIRE(!path.points.empty());
  CHECK(path.gap > 0.0);
  CHECK(path.gap < 0.2);
  CHECK(distance(path.points.back(), goal) == doctest::Approx(path.gap));
}

TEST_CASE("from outside of the grid no path leads anywhere") {
  OccupancyGrid grid;
  grid.width = grid.height = 60;
  grid.data.assign(3600, OccupancyGrid::kFree);
  Costmap costmap;
  costmap.update(grid, {}, std::vector<Vec2>{{410.0, 0.0}, {0.0, 1e300}});
  for (const double far : {410.0, -410.0, 1e6, 1e300}) {
    Planner planner;
    CHECK(planner.plan(costmap, {far, 1.5}, {1.0, 1.5}, 0.25).points.empty());
    CHECK(planner.plan(costmap, {1.5, far}, {1.0, 1.5}, 0.25).points.empty());
    CHECK(planner.plan(costmap, {1.0, 1.5}, {far, 1.5}, 0.25).points.empty());
    CHECK_FALSE(planner.plan(costmap, {1.0, 1.5}, {2.0, 1.5}, 0.25).points.empty());
  }
}

}  // namespace
}  // namespace threewe::nav
