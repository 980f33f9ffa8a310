// The cells that a straight line passes, exactly.
#pragma once

#include <cmath>
#include <cstdlib>
#include <limits>

#include "threewe/map/occupancy_grid.hpp"

namespace threewe::map {

/// Calls `visit(cell)` for every cell on the way from `a` to `b`, in order, both ends included. Points are in cells:
/// the cell of (x, y) is (floor(x), floor(y)). Ends when `visit` returns false (Amanatides & Woo 1987). A line through
/// a corner of four cells goes along y first.
template <class Visit>
void traverse(Vec2 a, Vec2 b, Visit visit) {
  const auto axis = [](double from, double to, int cell, double& next, double& step) {
    const double d = to - from;
    step = d != 0.0 ? 1.0 / std::fabs(d) : std::numeric_limits<double>::infinity();
    next = d > 0.0 ? (cell + 1 - from) * step : d < 0.0 ? (from - cell) * step : step;
    return d > 0.0 ? 1 : -1;
  };
  Cell c{static_cast<int>(std::floor(a.x)), static_cast<int>(std::floor(a.y))};
  const Cell end{static_cast<int>(std::floor(b.x)), static_cast<int>(std::floor(b.y))};
  double next_x = 0.0, next_y = 0.0, step_x = 0.0, step_y = 0.0;
  const int sign_x = axis(a.x, b.x, c.x, next_x, step_x);
  const int sign_y = axis(a.y, b.y, c.y, next_y, step_y);

  // counting the steps of each axis makes sure that rounding never misses the end
  int left_x = std::abs(end.x - c.x);
  int left_y = std::abs(end.y - c.y);
  while (visit(c) && left_x + left_y > 0) {
    if (left_y == 0 || (left_x > 0 && next_x < next_y)) {
      c.x += sign_x, next_x += step_x, --left_x;
    } else {
      c.y += sign_y, next_y += step_y, --left_y;
    }
  }
}

}  // namespace threewe::map
