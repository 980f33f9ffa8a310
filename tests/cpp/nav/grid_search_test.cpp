// The search for the nearest target against a plain Dijkstra, and frontiers.
#include "nav/grid_search.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <queue>
#include <random>
#include <vector>

#include "draw.hpp"
#include "nav/frontiers.hpp"
#include "nav/random_costmap.hpp"

namespace threewe::nav {
namespace {

using map::Cell;
using map::Costmap;
using map::OccupancyGrid;
using testing::random_cell;
using testing::random_costmap;

std::uint32_t step_cost(const Costmap& costmap, Cell from, Cell to) {
  const std::uint32_t w = std::min<std::uint32_t>(costmap.weight(from), 100);
  return (from.x == to.x || from.y == to.y ? 5U : 7U) * (w + costmap.weight(to));
}

// The cost of reaching every cell, by the book.
std::vector<std::uint32_t> dijkstra(const Costmap& costmap, Cell start) {
  std::vector<std::uint32_t> cost(costmap.weights().size(), std::numeric_limits<std::uint32_t>::max());
  using Entry = std::pair<std::uint32_t, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  cost[costmap.index(start)] = 0;
  queue.emplace(0, costmap.index(start));
  while (!queue.empty()) {
    const auto [c, index] = queue.top();
    queue.pop();
    if (c > cost[index]) continue;
    const auto width = static_cast<std::size_t>(costmap.width());
    const Cell here{static_cast<int>(index % width), static_cast<int>(index / width)};
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const Cell there{here.x + dx, here.y + dy};
        if ((dx == 0 && dy == 0) || !costmap.contains(there) || costmap.weight(there) == Costmap::kLethal) continue;
        const std::uint32_t next = c + step_cost(costmap, here, there);
        if (next >= cost[costmap.index(there)]) continue;
        cost[costmap.index(there)] = next;
        queue.emplace(next, costmap.index(there));
      }
    }
  }
  return cost;
}

TEST_CASE("a path to one target is as cheap as Dijkstra's, and costs what it says") {
  GridSearch search;
  std::uint64_t found = 0;
  std::uint64_t unreachable = 0;
  for (std::uint64_t seed = 0; seed < cases(3000); ++seed) {
    CAPTURE(seed);
    std::mt19937_64 bits(seed);
    const Costmap costmap = random_costmap(bits);
    const Cell start = random_cell(costmap, bits);
    const Cell goal = random_cell(costmap, bits);
    const std::uint32_t expected = dijkstra(costmap, start)[costmap.index(goal)];

    const auto is_goal = [&](std::uint32_t i) { return i == costmap.index(goal); };
    const SearchResult result = search.to_any(costmap, start, is_goal, [](std::uint32_t) { return false; });
    REQUIRE(result.found == (expected != std::numeric_limits<std::uint32_t>::max()));
    ++(result.found ? found : unreachable);
    if (!result.found) continue;
    REQUIRE(result.cost == expected);
    REQUIRE(result.path.front() == start);
    REQUIRE(result.path.back() == goal);
    std::uint32_t sum = 0;
    for (std::size_t i = 1; i < result.path.size(); ++i) {
      const Cell a = result.path[i - 1];
      const Cell b = result.path[i];
      REQUIRE(std::max(std::abs(a.x - b.x), std::abs(a.y - b.y)) == 1);
      REQUIRE(costmap.weight(b) != Costmap::kLethal);
      sum += step_cost(costmap, a, b);
    }
    REQUIRE(sum == result.cost);
  }
  CHECK(found > cases(500));
  CHECK(unreachable > cases(500));
}

TEST_CASE("the nearest of many targets is the cheapest of them") {
  GridSearch search;
  for (std::uint64_t seed = 0; seed < cases(1000); ++seed) {
    CAPTURE(seed);
    std::mt19937_64 bits(seed);
    const Costmap costmap = random_costmap(bits);
    const Cell start = random_cell(costmap, bits);
    std::vector<bool> target(costmap.weights().size());
    for (int i = 0; i < 5; ++i) target[costmap.index(random_cell(costmap, bits))] = true;

    const std::vector<std::uint32_t> costs = dijkstra(costmap, start);
    std::uint32_t expected = std::numeric_limits<std::uint32_t>::max();
    for (std::size_t i = 0; i < costs.size(); ++i) {
      if (target[i]) expected = std::min(expected, costs[i]);
    }
    const SearchResult result =
        search.to_any(costmap, start, [&](std::uint32_t i) { return target[i]; }, [](std::uint32_t) { return false; });
    REQUIRE(result.found == (expected != std::numeric_limits<std::uint32_t>::max()));
    if (result.found) REQUIRE(result.cost == expected);
  }
}

TEST_CASE("the best of many targets is the one whose cost less its bonus is least") {
  GridSearch search;
  for (std::uint64_t seed = 0; seed < cases(1000); ++seed) {
    CAPTURE(seed);
    std::mt19937_64 bits(seed);
    const Costmap costmap = random_costmap(bits);
    const Cell start = random_cell(costmap, bits);
    constexpr int kMost = 3000;
    std::vector<std::optional<int>> bonus(costmap.weights().size());
    for (int i = 0; i < 8; ++i) {
      bonus[costmap.index(random_cell(costmap, bits))] = kMost - static_cast<int>(bits() % 6000);
    }
    const std::vector<std::uint32_t> costs = dijkstra(costmap, start);
    std::optional<std::int64_t> expected;
    for (std::size_t i = 0; i < costs.size(); ++i) {
      if (!bonus[i] || costs[i] == std::numeric_limits<std::uint32_t>::max()) continue;
      const std::int64_t value = std::int64_t{costs[i]} - *bonus[i];
      expected = std::min(expected.value_or(value), value);
    }
    const SearchResult result = search.to_best(
        costmap, start, [&](std::uint32_t i) { return bonus[i]; }, kMost, [](std::uint32_t) { return false; });
    REQUIRE(result.found == expected.has_value());
    if (!expected) continue;
    const std::size_t end = costmap.index(result.path.back());
    REQUIRE(costs[end] == result.cost);
    REQUIRE(std::int64_t{result.cost} - *bonus[end] == *expected);
  }
}

// Candidates one by one, as the header defines them, for cells of 5 cm.
bool is_frontier(const Costmap& costmap, Cell c) {
  if (costmap.unknown(c) || costmap.weight(c) == Costmap::kLethal) return false;
  for (std::size_t i = 0; i < 4; ++i) {
    const Cell n{c.x + kDirections[i].x, c.y + kDirections[i].y};
    int unknown = 0;
    for (int dy = -2; dy <= 2; ++dy) {
      for (int dx = -2; dx <= 2; ++dx) unknown += costmap.unknown({n.x + dx, n.y + dy}) ? 1 : 0;
    }
    if (costmap.unknown(n) && unknown >= 12) return true;
  }
  return false;
}

TEST_CASE("frontiers are the cells that the definition names, in groups that flood fill finds") {
  long cells = 0;
  for (std::uint64_t seed = 0; seed < cases(400); ++seed) {
    CAPTURE(seed);
    std::mt19937_64 bits(seed);
    OccupancyGrid grid;
    grid.width = grid.height = 50;
    grid.data.assign(2500, OccupancyGrid::kUnknown);
    for (int i = 0; i < 6; ++i) {
      const int x0 = static_cast<int>(bits() % 40);
      const int y0 = static_cast<int>(bits() % 40);
      const auto value = i < 5 ? OccupancyGrid::kFree : OccupancyGrid::kOccupied;
      const int size = i < 5 ? 10 : 3;
      for (int y = y0; y < y0 + size; ++y) {
        for (int x = x0; x < x0 + size; ++x) grid.data[grid.index({x, y})] = value;
      }
    }
    Costmap costmap;
    costmap.update(grid, {}, {});
    std::vector<std::uint16_t> size_of;
    find_frontiers(costmap, {}, size_of);

    for (int y = 0; y < costmap.height(); ++y) {
      for (int x = 0; x < costmap.width(); ++x) {
        const bool frontier = is_frontier(costmap, {x, y});
        REQUIRE((size_of[costmap.index({x, y})] > 0) == frontier);
        if (!frontier) continue;
        ++cells;
        // flood fill from here
        std::vector<Cell> group = {{x, y}};
        std::vector<bool> seen(costmap.weights().size());
        seen[costmap.index({x, y})] = true;
        for (std::size_t i = 0; i < group.size(); ++i) {
          for (const Cell d : kDirections) {
            const Cell c{group[i].x + d.x, group[i].y + d.y};
            if (seen[costmap.index(c)] || !is_frontier(costmap, c)) continue;
            seen[costmap.index(c)] = true;
            group.push_back(c);
          }
        }
        REQUIRE(size_of[costmap.index({x, y})] == group.size());
      }
    }
  }
  CHECK(cells > 5000);
}

}  // namespace
}  // namespace threewe::nav
