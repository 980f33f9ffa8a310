// The cells of a grid that a straight line crosses.
#pragma once

#include <cmath>
#include <cstdlib>
#include <limits>

#include "threewe/core/pose.hpp"

namespace threewe {

/// Calls `visit(x, y)` for every cell on the way from `a` to `b`, in order, both ends included, while it returns true
/// (Amanatides & Woo 1987). Returns whether all were visited. Points are in cells: the cell of (x, y) is
/// (floor(x), floor(y)). A line through a corner of four cells goes along y first.
template <class Visit>
bool walk_grid_line(Vec2 a, Vec2 b, Visit visit) {
  struct Axis {
    int cell, sign, left;  // `left` counts the steps, so that rounding never misses the end
    double next, step;     // the fraction of the line at which the next cell begins, and how much each takes
  };
  const auto axis = [](double from, double to) {
    const double d = to - from;
    const double step = d != 0.0 ? 1.0 / std::fabs(d) : std::numeric_limits<double>::infinity();
    const int cell = static_cast<int>(std::floor(from));
    const int left = std::abs(static_cast<int>(std::floor(to)) - cell);
    const double next = d > 0.0 ? (cell + 1 - from) * step : d < 0.0 ? (from - cell) * step : step;
    return Axis{cell, d > 0.0 ? 1 : -1, left, next, step};
  };
  Axis x = axis(a.x, b.x);
  Axis y = axis(a.y, b.y);
  while (visit(x.cell, y.cell)) {
    if (x.left + y.left == 0) return true;
    Axis& forward = y.left == 0 || (x.left > 0 && x.next < y.next) ? x : y;
    forward.cell += forward.sign;
    forward.next += forward.step;
    --forward.left;
  }
  return false;
}

}  // namespace threewe
