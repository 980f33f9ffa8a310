// What several robots know together, cell by cell.
#include "nav/shared_map.hpp"

#include <doctest/doctest.h>

#include <random>
#include <vector>

#include "draw.hpp"

namespace threewe::nav {
namespace {

using map::OccupancyGrid;

OccupancyGrid random_grid(std::mt19937_64& bits) {
  OccupancyGrid grid;
  grid.width = 1 + static_cast<int>(bits() % 40);
  grid.height = 1 + static_cast<int>(bits() % 40);
  grid.origin = {0.05 * static_cast<double>(bits() % 60) - 1.5, 0.05 * static_cast<double>(bits() % 60) - 1.5};
  for (int i = 0; i < grid.width * grid.height; ++i) {
    const std::vector<std::int8_t> values = {-1, -1, 0, 100};
    grid.data.push_back(values[bits() % 4]);
  }
  return grid;
}

TEST_CASE("our own knowledge comes first, then that of peers in their order, and nothing is lost") {
  for (std::uint64_t seed = 0; seed < cases(500); ++seed) {
    CAPTURE(seed);
    std::mt19937_64 bits(seed);
    const OccupancyGrid ours = random_grid(bits);
    const OccupancyGrid first = random_grid(bits);
    const OccupancyGrid second = random_grid(bits);
    const std::vector<Peer> peers = {{.map = &first}, {.map = &second}};
    OccupancyGrid merged;
    merge_maps(ours, peers, merged);
    const auto known = [](const OccupancyGrid& grid, Vec2 p) { return grid.at(grid.cell(p)); };
    for (const OccupancyGrid* grid : {&ours, &first, &second}) {
      for (int y = 0; y < grid->height; ++y) {
        for (int x = 0; x < grid->width; ++x) {
          const Vec2 p = grid->center({x, y});
          std::int8_t expected = known(ours, p);
          if (expected < 0) expected = known(first, p);
          if (expected < 0) expected = known(second, p);
          REQUIRE(known(merged, p) == expected);
        }
      }
    }
  }
}

TEST_CASE("a peer that is too far away is left out") {
  std::mt19937_64 bits(1);
  const OccupancyGrid ours = random_grid(bits);
  OccupancyGrid far = random_grid(bits);
  far.origin = {1e6, 0.0};
  OccupancyGrid merged;
  merge_maps(ours, std::vector<Peer>{{.map = &far}}, merged);
  CHECK(merged == ours);
}

}  // namespace
}  // namespace threewe::nav
