#include "nav/frontier_worth.hpp"

#include <doctest/doctest.h>

#include <cstdint>
#include <random>
#include <vector>

#include "map/costmap.hpp"
#include "nav/frontiers.hpp"
#include "nav/random_costmap.hpp"
#include "threewe/map/occupancy_grid.hpp"

using namespace threewe;
using namespace threewe::nav;
using map::Cell;

namespace {

constexpr double kResolution = 0.05;

// A map in which everything is unknown.
map::OccupancyGrid unknown_map(int width, int height) {
  map::OccupancyGrid grid;
  grid.resolution = kResolution;
  grid.width = width;
  grid.height = height;
  grid.data.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), map::OccupancyGrid::kUnknown);
  return grid;
}

void fill(map::OccupancyGrid& grid, Cell low, Cell high, std::int8_t value) {
  for (int y = low.y; y <= high.y; ++y) {
    for (int x = low.x; x <= high.x; ++x) grid.data[static_cast<std::size_t>(y * grid.width + x)] = value;
  }
}

struct Seen {
  map::Costmap costmap{map::Costmap::Settings{.lethal_radius = 0.12, .caution_radius = 0.37}};
  std::vector<std::uint16_t> size_of;

  explicit Seen(const map::OccupancyGrid& grid) {
    costmap.update(grid, {}, {}, 20);
    find_frontiers(costmap, {}, size_of);
  }
  // A cell of the frontier nearest to a point.
  Cell frontier(Vec2 near) const {
    Cell best{};
    double least = 1e9;
    for (int y = 0; y < costmap.height(); ++y) {
      for (int x = 0; x < costmap.width(); ++x) {
        const double away = distance(costmap.center({x, y}), near);
        if (size_of[costmap.index({x, y})] != 0 && away < least) best = {x, y}, least = away;
      }
    }
    REQUIRE(least < 1e9);
    return best;
  }
  bool worthwhile(Cell frontier, double way) const { return is_worthwhile(costmap, {}, frontier, size_of, way); }
};

// A corridor, 4 m long and 1.5 m wide, with an opening of so many cells to the north.
map::OccupancyGrid corridor_with_opening(int opening, int depth_behind) {
  map::OccupancyGrid grid = unknown_map(100, 120);
  fill(grid, {10, 10}, {89, 39}, 0);
  fill(grid, {9, 9}, {90, 9}, 100);
  fill(grid, {9, 40}, {90, 40}, 100);
  fill(grid, {9, 9}, {9, 40}, 100);
  fill(grid, {90, 9}, {90, 40}, 100);
  fill(grid, {50, 40}, {49 + opening, 40}, map::OccupancyGrid::kUnknown);
  if (depth_behind > 0) fill(grid, {40, 41 + depth_behind}, {70 + opening, 42 + depth_behind}, 100);
  if (depth_behind > 0) fill(grid, {40, 40}, {41, 42 + depth_behind}, 100);
  if (depth_behind > 0) fill(grid, {69 + opening, 40}, {70 + opening, 42 + depth_behind}, 100);
  return grid;
}

}  // namespace

TEST_CASE("a doorway to a room that was never seen is worth the way through a building") {
  const Seen seen(corridor_with_opening(18, 0));
  const Cell door = seen.frontier({2.9, 1.95});
  CHECK(seen.worthwhile(door, 1.0));
  CHECK(seen.worthwhile(door, 15.0));
  CHECK_FALSE(seen.worthwhile(door, 100.0));
}

TEST_CASE("a niche behind the same opening is worth a few metres") {
  const Seen seen(corridor_with_opening(18, 10));
  const Cell niche = seen.frontier({2.9, 1.95});
  CHECK(seen.worthwhile(niche, 1.0));
  CHECK_FALSE(seen.worthwhile(niche, 15.0));
}

TEST_CASE("a slit is worth little, whatever may lie behind it") {
  const Seen seen(corridor_with_opening(10, 0));
  const Cell slit = seen.frontier({2.7, 1.95});
  CHECK_FALSE(seen.worthwhile(slit, 25.0));
}

TEST_CASE("what is worth a way is worth every shorter one, and what is dropped is gone") {
  std::mt19937_64 bits(20261124);
  for (int trial = 0; trial < 40; ++trial) {
    const map::OccupancyGrid grid = nav::testing::random_grid(bits);
    CAPTURE(trial);
    Seen seen(grid);
    const Vec2 robot = grid.origin;
    std::vector<std::uint16_t> left = seen.size_of;
    const bool dropped = drop_far_frontiers(seen.costmap, {}, robot, left);
    CHECK(dropped == (left != seen.size_of));
    for (int y = 0; y < seen.costmap.height(); ++y) {
      for (int x = 0; x < seen.costmap.width(); ++x) {
        const std::size_t i = seen.costmap.index({x, y});
        if (seen.size_of[i] == 0) continue;
        if ((x + y) % 7 == 0) {  // of so many cells, some
          bool before = true;
          for (const double way : {0.0, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0}) {
            const bool now = seen.worthwhile({x, y}, way);
            CHECK((before || !now));
            before = now;
          }
        }
        if (left[i] == 0) CHECK_FALSE(seen.worthwhile({x, y}, distance(seen.costmap.center({x, y}), robot) + 3.0));
        if (left[i] != 0) CHECK(left[i] == seen.size_of[i]);
      }
    }
    for (int y = 0; y < seen.costmap.height(); ++y) {
      for (int x = 0; x < seen.costmap.width(); ++x) {
        if (left[seen.costmap.index({x, y})] == 0) continue;
        drop_frontier(seen.costmap, {x, y}, left);
        CHECK(left[seen.costmap.index({x, y})] == 0);
      }
    }
  }
}
