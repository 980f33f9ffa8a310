#include "nav/planner.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "nav/tile_walk.hpp"

namespace threewe::nav {
namespace {

using map::Cell;
using map::Costmap;

// The point's own cell if it can be entered; else those within `radius` that can, the nearest first.
std::vector<Cell> free_cells_near(const Costmap& costmap, Vec2 point, double radius) {
  const Cell middle = costmap.cell(point);
  std::vector<std::pair<double, Cell>> cells;
  const int reach = map::to_cell(radius / costmap.resolution()) + 1;
  for (int y = std::max(0, middle.y - reach); y <= std::min(costmap.height() - 1, middle.y + reach); ++y) {
    for (int x = std::max(0, middle.x - reach); x <= std::min(costmap.width() - 1, middle.x + reach); ++x) {
      const Cell c{x, y};
      if (costmap.weight(c) == Costmap::kLethal) continue;
      const double d = c == middle ? 0.0 : distance(costmap.center(c), point);
      if (d < radius || c == middle) cells.emplace_back(d, c);
    }
  }
  std::stable_sort(cells.begin(), cells.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Cell> sorted;
  for (const auto& [d, c] : cells) sorted.push_back(c);
  return sorted;
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

// To the nearest cell of the goal that can be reached; mostly the goal itself.
PlannedPath Planner::plan(const Costmap& costmap, Vec2 from, Vec2 to, double tolerance) {
  const Cell start = costmap.cell(from);
  if (!costmap.contains(start)) return {};
  const std::optional<Cell> target = first_reached(costmap, start, to, tolerance);
  if (!target) return {};

  const bool exact = *target == costmap.cell(to);
  const Vec2 end = exact ? to : costmap.center(*target);
  PlannedPath path;
  path.points = straighten(costmap, walk_tiles(costmap, way_, start, *target), from, end);
  path.gap = distance(end, to);
  path.cost = path_cost(costmap, path.points);
  return path;
}

// Leaves the way to it in `way_`.
std::optional<Cell> Planner::first_reached(const Costmap& costmap, Cell start, Vec2 to, double tolerance) {
  bool searched = false;
  for (const Cell c : free_cells_near(costmap, to, tolerance)) {
    if (searched && !graph_.reaches(costmap, c)) continue;
    searched = true;
    const std::optional<TileWay> way = graph_.find(costmap, start, c);
    if (!way) continue;
    way_ = *way;
    return c;
  }
  return {};
}

std::vector<Vec2> straighten(const Costmap& costmap, const std::vector<Cell>& cells, Vec2 from, Vec2 to) {
  std::vector<Vec2> raw;
  raw.push_back(from);
  for (std::size_t i = 1; i + 1 < cells.size(); ++i) raw.push_back(costmap.center(cells[i]));
  raw.push_back(to);

  // what it costs to come to each of them, and where the direction changes
  std::vector<double> cost = {0.0};
  std::vector<std::size_t> corners;
  for (std::size_t i = 1; i < raw.size(); ++i) {
    cost.push_back(cost.back() + step_cost(costmap, raw[i - 1], raw[i]));
    const bool turns = i + 1 >= cells.size() || cells[i].x - cells[i - 1].x != cells[i + 1].x - cells[i].x ||
                       cells[i].y - cells[i - 1].y != cells[i + 1].y - cells[i].y;
    if (turns) corners.push_back(i);
  }

  std::vector<Vec2> points = {from};
  std::size_t here = 0;
  for (std::size_t next = 0; next < corners.size();) {
    // as far as a straight line is free and no dearer; a few failures are looked past, they come from the raster
    std::size_t best = next;
    int failures = 0;
    for (std::size_t j = next + 1; j < corners.size() && failures < 10; ++j) {
      const double line = costmap.line_cost(raw[here], raw[corners[j]]);
      if (std::isfinite(line) && line <= cost[corners[j]] - cost[here] + 1e-9) {
        best = j, failures = 0;
      } else {
        ++failures;
      }
    }
    here = corners[best];
    next = best + 1;
    points.push_back(raw[here]);
  }
  return points;
}

}  // namespace threewe::nav
