// Global path planner on a costmap.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "map/costmap.hpp"
#include "nav/tile_graph.hpp"

namespace threewe::nav {

/// A way to a goal.
struct PlannedPath {
  std::vector<Vec2> points;  ///< in `map`, from the robot to the goal; empty where there is none
  double gap = 0.0;          ///< [m] from the end of the path to the goal; 0 when the path reaches it
  double cost = 0.0;         ///< [m times weight] of the whole path
};

/// The cost of a polyline [m times weight]; infinity where it meets a lethal cell.
double path_cost(const map::Costmap& costmap, std::span<const Vec2> path);
/// Length [m] of a polyline.
double path_length(std::span<const Vec2> path);

/// Keeps of a path of cells the points that are needed for every piece to cost no more than the cells did. The ends may
/// lie anywhere in their cells.
std::vector<Vec2> straighten(const map::Costmap& costmap, const std::vector<map::Cell>& cells, Vec2 from, Vec2 to);

/// Paths through space that is free or unknown: through tiles first, then cell by cell within those, then straightened
/// at any angle. What it keeps between plans are the tables of tiles, which change nothing but the time. Used by
/// `Route`.
class Planner {
 public:
  /// No path where `costmap` does not hold `from`: the robot is farther from its map than a grid goes. Where the goal's
  /// own cell cannot be reached the path ends in the nearest one, less than `tolerance` [m] away, that can. No path
  /// means that there is none: everything within reach was searched.
  PlannedPath plan(const map::Costmap& costmap, Vec2 from, Vec2 to, double tolerance);
  const TileGraph& graph() const { return graph_; }

 private:
  std::optional<map::Cell> first_reached(const map::Costmap& costmap, map::Cell start, Vec2 to, double tolerance);

  TileGraph graph_;
  TileWay way_;  // to what was reached
};

}  // namespace threewe::nav
