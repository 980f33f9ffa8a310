// From a map to a path.
#pragma once

#include <span>
#include <vector>

#include "threewe/map/costmap.hpp"
#include "threewe/nav/grid_search.hpp"

namespace threewe::nav {

/// A way to a goal.
struct PlannedPath {
  std::vector<Vec2> points;  ///< in `map`, from the robot to the goal or as near to it as possible
  double gap = 0.0;          ///< [m] from the end of the path to the goal; 0 when the path reaches it
  double cost = 0.0;         ///< [m times weight] of the whole path
};

/// The cost of a polyline [m times weight]; infinity where it meets a lethal cell.
double path_cost(const map::Costmap& costmap, std::span<const Vec2> path);
/// Length [m] of a polyline.
double path_length(std::span<const Vec2> path);

/// A* through space that is free or unknown, then straightened.
class Planner {
 public:
  /// `costmap` must hold both points. A goal nearer than `tolerance` [m] to free cells is reached at the nearest.
  PlannedPath plan(const map::Costmap& costmap, Vec2 from, Vec2 to, double tolerance);
  /// Straightens a path of cells: keeps the points that are needed for every piece to cost no more than the cells did.
  static std::vector<Vec2> straighten(const map::Costmap& costmap, const std::vector<map::Cell>& cells, Vec2 from,
                                      Vec2 to);
  GridSearch& search() { return search_; }

 private:
  GridSearch search_;
};

}  // namespace threewe::nav
