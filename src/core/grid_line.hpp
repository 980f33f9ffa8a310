// The cells of a grid that a straight line crosses.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <utility>

#include "threewe/core/grid_index.hpp"
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
  a = clamp_to_far_cells(a), b = clamp_to_far_cells(b);
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

/// Calls `visit(x, y)` for every cell on the way from `a` to `b`, in no order, some of them twice: fast, for marks.
/// Rows are computed in fixed point: off by at most 2^-32 of a cell for each column gone by.
template <class Visit>
void mark_grid_line(Vec2 a, Vec2 b, Visit visit) {
  constexpr double kOne = 0x1p32;
  a = clamp_to_far_cells(a), b = clamp_to_far_cells(b);
  const bool steep = std::fabs(b.y - a.y) > std::fabs(b.x - a.x);
  if (steep) std::swap(a.x, a.y), std::swap(b.x, b.y);
  if (a.x > b.x) std::swap(a, b);
  // column by column; the line changes by at most one row in each
  const auto mark_all = [&](auto mark) {
    const int first = static_cast<int>(std::floor(a.x));
    const int last = static_cast<int>(std::floor(b.x));
    const double slope = b.x > a.x ? (b.y - a.y) / (b.x - a.x) : 0.0;
    const auto end = static_cast<std::int64_t>(std::floor(b.y * kOne));
    const auto rise = static_cast<std::int64_t>(std::floor(slope * kOne));
    auto row = static_cast<std::int64_t>(std::floor(a.y * kOne));
    auto next = static_cast<std::int64_t>(std::floor((a.y + (first + 1 - a.x) * slope) * kOne));
    for (int column = first; column < last; ++column) {
      mark(column, static_cast<int>(row >> 32));
      mark(column, static_cast<int>(next >> 32));
      row = next;
      next += rise;
    }
    mark(last, static_cast<int>(row >> 32));
    mark(last, static_cast<int>(end >> 32));
  };
  if (steep) {
    mark_all([&](int x, int y) { visit(y, x); });
  } else {
    mark_all(visit);
  }
}

}  // namespace threewe
