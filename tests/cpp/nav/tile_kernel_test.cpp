// Costs within a tile against Dijkstra's, and the same bits whatever the vectors.
#include "nav/tile_kernel.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cstddef>
#include <memory>
#include <queue>
#include <utility>
#include <vector>

#include "core/targets.hpp"
#include "draw.hpp"

namespace threewe::nav::kernel {
namespace {

// The weight under each of the cells that a step's line crosses.
std::int32_t step_cost(const Steps& steps, int x, int y, int dx, int dy) {
  const auto weight = [&](int u, int v) { return steps.weight[static_cast<std::size_t>(place(u, v))]; };
  const std::int32_t ends = weight(x, y) + weight(x + dx, y + dy);
  if (dx * dy == 0) return 128 * ends;
  if (dx * dx == dy * dy) return 181 * ends;
  const int sx = dx > 0 ? 1 : -1;
  const int sy = dy > 0 ? 1 : -1;
  const bool flat = dx * dx > dy * dy;
  return 143 * (ends + weight(x + (flat ? sx : 0), y + (flat ? 0 : sy)) + weight(x + sx, y + sy));
}

// By the book, over all 16 directions.
std::vector<std::int32_t> dijkstra(const Steps& steps, int x, int y) {
  std::vector<std::int32_t> cost(kCells, kUnreached);
  using Entry = std::pair<std::int32_t, std::pair<int, int>>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  cost[static_cast<std::size_t>(place(x, y))] = 0;
  queue.push({0, {x, y}});
  while (!queue.empty()) {
    const auto [c, cell] = queue.top();
    queue.pop();
    const auto [u, v] = cell;
    if (c > cost[static_cast<std::size_t>(place(u, v))]) continue;
    for (int dy = -2; dy <= 2; ++dy) {
      for (int dx = -2; dx <= 2; ++dx) {
        const int squared = dx * dx + dy * dy;
        const bool inside = u + dx >= 0 && v + dy >= 0 && u + dx < kSide && v + dy < kSide;
        if ((squared != 1 && squared != 2 && squared != 5) || !inside) continue;
        const std::int32_t next = c + step_cost(steps, u, v, dx, dy);
        std::int32_t& there = cost[static_cast<std::size_t>(place(u + dx, v + dy))];
        if (next >= there) continue;
        there = next;
        queue.push({next, {u + dx, v + dy}});
      }
    }
  }
  return cost;
}

// Some walls, some of them with gaps, and weights of all sizes.
void draw_weights(Draw& draw, Steps& steps) {
  steps.weight.fill(kWall);
  const int dearest = draw.whole(4, 72);
  const int walls = draw.whole(0, 40);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      steps.weight[static_cast<std::size_t>(place(x, y))] = draw.whole(0, 99) < walls ? kWall : draw.whole(4, dearest);
    }
  }
  for (int i = draw.whole(0, 6); i > 0; --i) {
    const int at = draw.whole(0, kSide - 1);
    const int gap = draw.whole(0, kSide - 1);
    const bool across = draw.whole(0, 1) == 0;
    for (int u = 0; u < kSide; ++u) {
      if (u != gap) steps.weight[static_cast<std::size_t>(across ? place(at, u) : place(u, at))] = kWall;
    }
  }
  set_costs(steps);
}

TEST_CASE("costs spread through a tile as Dijkstra says, from one place and from eight, with any vectors") {
  const auto steps = std::make_unique<Steps>();
  const auto one = std::make_unique<Costs>();
  const auto many = std::make_unique<ManyCosts>();
  for (auto& cost : steps->cost) cost.fill(-12345);  // whatever was there before
  for (const std::string& target : available_targets()) {
    CAPTURE(target);
    force_target(target);
    for (std::uint64_t seed = 0; seed < cases(200); ++seed) {
      CAPTURE(seed);
      Draw draw(seed);
      draw_weights(draw, *steps);
      std::array<std::pair<int, int>, kLanes> from;
      for (auto& [x, y] : from) x = draw.whole(0, kSide - 1), y = draw.whole(0, kSide - 1);

      for (auto& lanes : many->at) lanes.fill(kUnreached);
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        many->at[static_cast<std::size_t>(place(from[lane].first, from[lane].second))][lane] = 0;
      }
      spread(*steps, *many);
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const auto [x, y] = from[lane];
        if (steps->weight[static_cast<std::size_t>(place(x, y))] == kWall) continue;
        one->at.fill(kUnreached);
        one->at[static_cast<std::size_t>(place(x, y))] = 0;
        spread(*steps, *one);
        const std::vector<std::int32_t> expected = dijkstra(*steps, x, y);
        for (std::size_t i = 0; i < kCells; ++i) {
          REQUIRE(many->at[i][lane] == expected[i]);
          REQUIRE(one->at[i] == expected[i]);
        }
      }
    }
  }
  force_target("");
}

}  // namespace
}  // namespace threewe::nav::kernel
