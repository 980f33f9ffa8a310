// The cells of a grid over a scene that a straight line crosses.
#pragma once

#include "core/grid_line.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/scene/cell_grid.hpp"

namespace threewe::scene {

/// Calls `visit(cell)` for every cell that the straight line from `a` to `b` crosses, in order, while it returns true.
/// Returns whether all were visited. Cells may lie outside the grid.
template <typename Visit>
bool walk_line(const GridFrame& frame, Vec2 a, Vec2 b, Visit visit) {
  const double scale = 1.0 / frame.resolution;
  return walk_grid_line(scale * (a - frame.origin), scale * (b - frame.origin),
                        [&](int x, int y) { return visit(CellIndex{x, y}); });
}

/// Calls `mark(index)` for every cell of the grid that the straight line from `a` to `b` crosses, in no order, some of
/// them twice.
template <class Mark>
void mark_line(const GridFrame& frame, Vec2 a, Vec2 b, Mark mark) {
  const double scale = 1.0 / frame.resolution;
  mark_grid_line(scale * (a - frame.origin), scale * (b - frame.origin), [&](int x, int y) {
    if (frame.contains({x, y})) mark(frame.index({x, y}));
  });
}

}  // namespace threewe::scene
