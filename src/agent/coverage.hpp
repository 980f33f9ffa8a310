// Camera coverage: which free floor the camera has seen, and where to go to see the rest.
#pragma once

#include <functional>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "threewe/core/pose.hpp"
#include "threewe/map/occupancy_grid.hpp"

namespace threewe::agent {

/// Floor in squares of this side [m].
inline constexpr double kSquare = 0.25;
using Square = std::pair<int, int>;

Square square_of(Vec2 point);
Vec2 center_of(Square square);
/// Whether nothing stands between two points, by a map.
bool in_sight(const map::OccupancyGrid& grid, Vec2 from, Vec2 to);

/// Shortest ways over the floor that a map knows to be free, from one point: breadth first, over squares with room for
/// a robot.
class Reachable {
 public:
  /// `clearance` [m] from what is occupied.
  Reachable(const map::OccupancyGrid& grid, Vec2 from, double clearance);
  /// All squares that can be reached, the nearest first.
  const std::vector<Square>& squares() const { return squares_; }
  /// The length [m] of the way to each of them.
  const std::vector<double>& ways() const { return ways_; }
  /// The nearest of them for which a predicate holds.
  std::optional<Vec2> nearest(const std::function<bool(Vec2)>& fits) const;
  /// The one for which a cost is least.
  std::optional<Vec2> best(const std::function<double(Vec2)>& cost) const;
  /// The same, of a cost that knows the length [m] of the way there, too.
  std::optional<Vec2> best(const std::function<double(Vec2, double)>& cost) const;

 private:
  std::vector<Square> squares_;
  std::vector<double> ways_;
};

/// Where to stand, and which way to look.
struct Viewpoint {
  Vec2 stand;
  double heading = 0.0;  ///< [rad]
  Square shows{};        ///< what is seen from there
};

/// Squares that the camera has seen from near enough to tell what stands on them.
class Coverage {
 public:
  /// A view from a camera's pose with a horizontal field of view [rad].
  void add(const map::OccupancyGrid& grid, const Pose2D& map_from_camera, double field_of_view);
  void add(Square square) { seen_.insert(square); }
  bool has(Square square) const { return seen_.contains(square); }
  /// The nearest place from which something unseen is in sight, within `area` where given; none when all is seen.
  /// `detour` says how much longer [m] than the shortest the way to a point may be, where given.
  std::optional<Viewpoint> next(const map::OccupancyGrid& grid, const Reachable& reachable,
                                const std::function<bool(Vec2)>& area,
                                const std::function<double(Vec2)>& detour = {}) const;

 private:
  std::set<Square> seen_;
};

}  // namespace threewe::agent
