// Visibility sets of the ray caster: for each cell of a grid, the shapes that some ray from it could hit first.
#pragma once

#include <cmath>
#include <vector>

#include "threewe/core/pose.hpp"
#include "threewe/scene/solid.hpp"

namespace threewe::sim {

/// Square cells over the bounding box of a slice.
struct CellGrid {
  static constexpr double kSize = 0.5;  ///< [m] of a cell
  Vec2 origin;                          ///< corner of cell 0
  int width = 0;
  int height = 0;

  int count() const { return width * height; }
  Vec2 center(int cell) const {
    const int column = cell % width;
    const int row = cell / width;
    return origin + kSize * Vec2{column + 0.5, row + 0.5};
  }
  /// The cell that holds a point, or -1 outside.
  int cell(Vec2 point) const {
    const double x = (point.x - origin.x) / kSize;
    const double y = (point.y - origin.y) / kSize;
    const bool inside = x >= 0.0 && y >= 0.0 && x < width && y < height;
    return inside ? static_cast<int>(y) * width + static_cast<int>(x) : -1;
  }
};

/// The grid that covers a slice.
CellGrid covering_grid(const scene::Slice& slice);

/// Indices of segments and circles of a slice.
struct VisibleSet {
  std::vector<int> segments;
  std::vector<int> circles;
};

/// The potentially visible set of every cell. Nothing that a ray of at most `range_max` [m] from anywhere in the cell
/// meets first is missing: a shape is left out only if it faces away from all of the cell, is out of range, or stands
/// wholly behind one convex solid.
std::vector<VisibleSet> potentially_visible_sets(const scene::Slice& slice, const CellGrid& grid, double range_max);

}  // namespace threewe::sim
