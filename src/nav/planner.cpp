#include "threewe/nav/planner.hpp"

#include <cmath>
#include <limits>

namespace threewe::nav {
namespace {

using map::Cell;
using map::Costmap;

// The cell with finite weight that is nearest to a point within `radius`; the point's own cell when there is none.
Cell nearest_free_cell(const Costmap& costmap, Vec2 point, double radius) {
  const Cell middle = costmap.cell(point);
  if (costmap.weight(middle) != Costmap::kLethal) return middle;
  const int reach = static_cast<int>(radius / costmap.resolution()) + 1;
  Cell best = middle;
  double best_distance = radius;
  for (int y = middle.y - reach; y <= middle.y + reach; ++y) {
    for (int x = middle.x - reach; x <= middle.x + reach; ++x) {
      const Cell c{x, y};
      if (!costmap.contains(c) || costmap.weight(c) == Costmap::kLethal) continue;
      const double d = distance(costmap.center(c), point);
      if (d < best_distance) best = c, best_distance = d;
    }
  }
  return best;
}

// What one step of a search costs [m times weight]. Its line may touch a lethal cell: at the corner that a diagonal
// step cuts, or where the robot stands in one.
double step_cost(const Costmap& costmap, Vec2 a, Vec2 b) {
  const double line = costmap.line_cost(a, b);
  return std::isfinite(line) ? line : distance(a, b) * costmap.weight(costmap.cell(b));
}

}  // namespace

double path_cost(const map::Costmap& costmap, std::span<const Vec2> path) {
  double sum = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) sum += costmap.line_cost(path[i - 1], path[i]);
  return sum;
}

double path_length(std::span<const Vec2> path) {
  double sum = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) sum += distance(path[i - 1], path[i]);
  return sum;
}

PlannedPath Planner::plan(const Costmap& costmap, Vec2 from, Vec2 to, double tolerance) {
  const Cell target = nearest_free_cell(costmap, to, tolerance);
  const SearchResult found = search_.to_cell(costmap, costmap.cell(from), target);
  PlannedPath path;
  if (found.path.empty()) return path;

  // the very goal where its cell was reached, else the middle of the nearest cell that was
  const bool exact = found.found && target == costmap.cell(to);
  const Vec2 end = exact ? to : costmap.center(found.path.back());
  path.points = straighten(costmap, found.path, from, end);
  path.gap = distance(end, to);
  path.cost = path_cost(costmap, path.points);
  return path;
}

std::vector<Vec2> Planner::straighten(const Costmap& costmap, const std::vector<Cell>& cells, Vec2 from, Vec2 to) {
  std::vector<Vec2> raw;
  raw.push_back(from);
  for (std::size_t i = 1; i + 1 < cells.size(); ++i) raw.push_back(costmap.center(cells[i]));
  raw.push_back(to);

  std::vector<Vec2> points = {from};
  std::size_t i = 0;
  while (i + 1 < raw.size()) {
    // as far as a straight line is free and no dearer; a few failures are looked past, they come from the raster
    double cost = step_cost(costmap, raw[i], raw[i + 1]);
    std::size_t best = i + 1;
    int failures = 0;
    for (std::size_t j = i + 2; j < raw.size() && failures < 10; ++j) {
      cost += step_cost(costmap, raw[j - 1], raw[j]);
      const double line = costmap.line_cost(raw[i], raw[j]);
      if (std::isfinite(line) && line <= cost + 1e-9) {
        best = j, failures = 0;
      } else {
        ++failures;
      }
    }
    points.push_back(raw[best]);
    i = best;
  }
  return points;
}

}  // namespace threewe::nav
