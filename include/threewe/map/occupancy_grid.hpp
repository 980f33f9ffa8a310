// Occupancy grid: cells that are free, occupied or unknown.
#pragma once

#include <cstdint>
#include <vector>

#include "threewe/core/grid_index.hpp"
#include "threewe/core/pose.hpp"

namespace threewe::map {

/// Indices of a cell: column along x, row along y.
struct Cell {
  int x = 0;  ///< column
  int y = 0;  ///< row
  friend bool operator==(const Cell&, const Cell&) = default;
};

using threewe::to_cell;

/// Whether a map or costmap of so many cells is small enough to keep: 400 m across, 200 m x 200 m in all at 5 cm, so
/// that one mad pose costs neither gigabytes nor seconds.
inline bool fits_a_grid(double columns, double rows) {
  constexpr double kMaxSide = 8192.0;
  constexpr double kMaxCells = 4096.0 * 4096.0;
  return columns <= kMaxSide && rows <= kMaxSide && columns * rows <= kMaxCells;
}

/// A grid of occupancy values as ROS defines them (nav_msgs/OccupancyGrid): -1 unknown, 0 free to 100 occupied.
/// Row-major, shape (height, width); cell (0, 0) has its lower left corner at `origin`, axes along the map frame's.
struct OccupancyGrid {
  int width = 0;                  ///< cells along x
  int height = 0;                 ///< cells along y
  double resolution = 0.05;       ///< [m] a cell
  Vec2 origin;                    ///< [m], of the corner of cell (0, 0)
  std::vector<std::int8_t> data;  ///< (height, width), row-major: -1, or 0 to 100

  /// Whether there is such a cell.
  bool contains(Cell c) const { return c.x >= 0 && c.y >= 0 && c.x < width && c.y < height; }
  /// The place of a cell in `data`. The cell must be on the grid.
  std::size_t index(Cell c) const {
    return static_cast<std::size_t>(c.y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(c.x);
  }
  /// The value at a cell; unknown outside the grid.
  std::int8_t at(Cell c) const { return contains(c) ? data[index(c)] : kUnknown; }
  /// The cell that holds a point [m] of the map frame; it may lie outside the grid.
  Cell cell(Vec2 point) const {
    return {to_cell((point.x - origin.x) / resolution), to_cell((point.y - origin.y) / resolution)};
  }
  /// The middle [m] of a cell in the map frame.
  Vec2 center(Cell c) const { return {origin.x + (c.x + 0.5) * resolution, origin.y + (c.y + 0.5) * resolution}; }

  /// Never measured.
  static constexpr std::int8_t kUnknown = -1;
  /// Crossed by beams.
  static constexpr std::int8_t kFree = 0;
  /// Hit by beams.
  static constexpr std::int8_t kOccupied = 100;
  /// At or above this a cell counts as occupied (ROS map_server's default).
  static constexpr std::int8_t kOccupiedThreshold = 65;
  /// At or below this, and not unknown, a cell counts as free.
  static constexpr std::int8_t kFreeThreshold = 25;
  friend bool operator==(const OccupancyGrid&, const OccupancyGrid&) = default;
};

inline constexpr double kFinestResolution = 0.001;   ///< [m] a cell
inline constexpr double kCoarsestResolution = 10.0;  ///< [m] a cell
/// Throws ContractError naming the field unless a grid is of cells that a map can have, as many as it says, no farther
/// away than places are.
void check_bounds(const OccupancyGrid& grid);

/// Where cell (0, 0) of a grid is in its raster: counted from the cell whose lower left corner is at (0, 0) m.
inline Cell raster_cell(const OccupancyGrid& grid) {
  return {to_cell(grid.origin.x / grid.resolution + 0.5), to_cell(grid.origin.y / grid.resolution + 0.5)};
}

}  // namespace threewe::map
