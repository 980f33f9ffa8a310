// Small places to plan in: closed all around, with walls, doors and things that stand about.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <random>

#include "map/costmap.hpp"

namespace threewe::nav::testing {

/// Some of it unknown, some of it out of reach.
inline map::OccupancyGrid random_grid(std::mt19937_64& bits, unsigned most = 70) {
  using map::OccupancyGrid;
  OccupancyGrid grid;
  grid.width = 12 + static_cast<int>(bits() % most);
  grid.height = 12 + static_cast<int>(bits() % most);
  grid.origin = {0.05 * static_cast<double>(bits() % 100) - 2.5, 0.05 * static_cast<double>(bits() % 100) - 2.5};
  grid.data.resize(static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height));
  const auto density = bits() % 4;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const bool edge = x == 0 || y == 0 || x == grid.width - 1 || y == grid.height - 1;
      grid.data[grid.index({x, y})] = edge || bits() % 200 < density
                                          ? OccupancyGrid::kOccupied
                                          : (bits() % 4 == 0 ? OccupancyGrid::kUnknown : OccupancyGrid::kFree);
    }
  }
  // walls with or without a door
  for (auto walls = bits() % 4; walls > 0; --walls) {
    const bool across = bits() % 2 == 0;
    const int along = across ? grid.height : grid.width;
    const int at = static_cast<int>(bits() % static_cast<unsigned>(across ? grid.width : grid.height));
    const int door = static_cast<int>(bits() % static_cast<unsigned>(along + along / 2));
    for (int u = 0; u < along; ++u) {
      if (std::abs(u - door) > 4)
        grid.data[grid.index(across ? map::Cell{at, u} : map::Cell{u, at})] = OccupancyGrid::kOccupied;
    }
  }
  return grid;
}

inline map::Costmap random_costmap(std::mt19937_64& bits, unsigned most = 70) {
  map::Costmap costmap;
  costmap.update(random_grid(bits, most), {}, {}, 0);
  return costmap;
}

inline map::Cell random_cell(const map::Costmap& costmap, std::mt19937_64& bits) {
  return {static_cast<int>(bits() % static_cast<unsigned>(costmap.width())),
          static_cast<int>(bits() % static_cast<unsigned>(costmap.height()))};
}

/// One that can be entered, where a few draws find one.
inline map::Cell random_free_cell(const map::Costmap& costmap, std::mt19937_64& bits) {
  map::Cell c = random_cell(costmap, bits);
  for (int i = 0; i < 50 && costmap.weight(c) == map::Costmap::kLethal; ++i) c = random_cell(costmap, bits);
  return c;
}

}  // namespace threewe::nav::testing
