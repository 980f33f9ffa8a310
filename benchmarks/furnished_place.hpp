// A place of 200 m x 200 m for planners: 25 generated buildings side by side, with doors from each to the next.
#pragma once

#include <algorithm>

#include "scene/occupancy.hpp"
#include "threewe/map/occupancy_grid.hpp"
#include "threewe/scene/generator.hpp"

namespace threewe {

inline constexpr int kBuildings = 5;       // along each side
inline constexpr int kBuildingSide = 800;  // [cells of 5 cm]

/// Where walls and the furniture of 0.15 m height and less are, exactly.
class FurnishedPlace {
 public:
  FurnishedPlace() {
    grid.width = grid.height = kBuildings * kBuildingSide;
    grid.data.assign(static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height), 0);
    for (int j = 0; j < kBuildings; ++j) {
      for (int i = 0; i < kBuildings; ++i) build(i, j);
    }
    for (int at = kBuildingSide; at < grid.width; at += kBuildingSide) {
      for (int along = 0; along < grid.width; along += kBuildingSide) {
        open_doors([&](int across, int u) { return map::Cell{at + across, along + u}; });
        open_doors([&](int across, int u) { return map::Cell{along + u, at + across}; });
      }
    }
  }

  map::OccupancyGrid grid;

 private:
  void build(int column, int row) {
    const auto seed = static_cast<std::uint64_t>(1 + kBuildings * row + column);
    const double side = kBuildingSide * scene::kCellSize;
    const scene::Scene building = scene::generate(seed, {.difficulty = 0.5, .size = {side, side}});
    const Vec2 corner = 0.5 * (building.min + building.max) - Vec2{0.5 * side, 0.5 * side};
    const scene::GridFrame frame{corner, scene::kCellSize, kBuildingSide, kBuildingSide};
    const scene::CellSet occupied = scene::occupied_cells(frame, building.solids_between(0.0, 0.15));
    for (int y = 0; y < kBuildingSide; ++y) {
      for (int x = 0; x < kBuildingSide; ++x) {
        if (occupied[{x, y}] == 0) continue;
        grid.data[grid.index({column * kBuildingSide + x, row * kBuildingSide + y})] = map::OccupancyGrid::kOccupied;
      }
    }
  }

  // Up to three doors of 1 m in the wall between two buildings, where there is room on both sides of it.
  template <class CellAt>
  void open_doors(CellAt cell_at) {
    constexpr int kWall = 3;   // [cells] from the middle of the wall, at least
    constexpr int kRoom = 20;  // [cells]
    const auto is_free = [&](int u) {
      for (int v = u; v < u + kRoom; ++v) {
        for (int across = kWall; across < kRoom; ++across) {
          if (grid.at(cell_at(across, v)) != 0 || grid.at(cell_at(-across - 1, v)) != 0) return false;
        }
      }
      return true;
    };
    int doors = 0;
    for (int u = kRoom; u < kBuildingSide - 2 * kRoom && doors < 3; ++u) {
      if (!is_free(u)) continue;
      for (int v = u; v < u + kRoom; ++v) {
        for (int across = -kWall; across < kWall; ++across) grid.data[grid.index(cell_at(across, v))] = 0;
      }
      ++doors;
      u += kBuildingSide / 4;
    }
  }
};

}  // namespace threewe
