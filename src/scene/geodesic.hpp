// Geodesic distance fields around obstacles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "threewe/scene/cell_grid.hpp"

namespace threewe::scene {

/// The length of the shortest path from anywhere to one target, or to the nearest of many, for a point that stays in a
/// set of cells. Along a clear straight line to one target it is the distance; elsewhere it is solved by fast marching
/// of second order (Sethian 1999), within 2 % of the truth and mostly 1 %. A point just beside the set may leave it by
/// one cell. Const once built: building takes milliseconds, asking takes about a microsecond.
class GeodesicField {
 public:
  /// `passable` must outlive the field. Lengths far above `limit` [m] are not solved for: they are infinite.
  GeodesicField(const CellSet& passable, Vec2 target, double limit = std::numeric_limits<double>::infinity());
  /// To the nearest of the middles of the cells with these indices; those that are not passable do not count. Within
  /// 4 cm and 2 % of the truth.
  GeodesicField(const CellSet& passable, std::span<const std::size_t> targets,
                double limit = std::numeric_limits<double>::infinity());

  /// Where there is one.
  const std::optional<Vec2>& target() const { return target_; }
  /// Length [m] of the shortest path from a point to the target; infinity where there is none.
  double length_from(Vec2 point) const;
  /// The corners of a shortest path from a point to the target, both included; empty where there is none. At most a few
  /// percent longer than `length_from`.
  std::vector<Vec2> path_from(Vec2 point) const;

 private:
  std::vector<std::uint32_t> cells_around(Vec2 target);
  void march(const std::vector<std::uint32_t>& known, double limit);
  double solve(std::uint32_t cell) const;
  double interpolate(Vec2 point) const;
  bool sees_target(Vec2 point) const;
  bool sees(Vec2 a, Vec2 b) const;
  std::vector<CellIndex> descend(CellIndex cell) const;
  std::uint32_t index(CellIndex c) const;

  const CellSet* passable_;
  std::optional<Vec2> target_;  // where there is one
  std::uint32_t stride_;        // of a row of `length_`, which has a border of two cells on every side
  std::vector<double> length_;  // [cells], infinite where unknown
};

}  // namespace threewe::scene
