// Column and row of a point in a grid.
#pragma once

#include "threewe/core/pose.hpp"

namespace threewe {

/// So far from the first a column or row is outside of any grid, and still a number to compute with.
inline constexpr double kFarCell = 1 << 28;
/// The number of cells, kept within what can be converted to an index.
inline double clamp_to_far_cells(double cells) {
  if (!(cells > -kFarCell)) return -kFarCell;  // NaN as well
  return cells < kFarCell ? cells : kFarCell;
}
/// The same along both axes.
inline Vec2 clamp_to_far_cells(Vec2 cells) { return {clamp_to_far_cells(cells.x), clamp_to_far_cells(cells.y)}; }

/// The column or row `cells` cells from the first. Points too far away for any grid, and NaN, end far outside instead.
inline int to_cell(double cells) {
  const double within = clamp_to_far_cells(cells);
  const int towards_zero = static_cast<int>(within);
  return towards_zero - (within < towards_zero ? 1 : 0);  // where floor is a call, it takes longer than all the rest
}

}  // namespace threewe
