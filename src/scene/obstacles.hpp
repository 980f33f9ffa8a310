// Obstacle index with exact collision tests.
#pragma once

#include <vector>

#include "threewe/core/footprint.hpp"
#include "threewe/scene/cell_grid.hpp"
#include "threewe/scene/solid.hpp"

namespace threewe::scene {

/// Solids, indexed by place. Const and shared.
class Obstacles {
 public:
  explicit Obstacles(std::vector<Solid> solids);

  const std::vector<Solid>& solids() const { return solids_; }
  /// Whether the footprint overlaps a solid; touching is no collision.
  bool collides(const Footprint& footprint, const Pose2D& pose) const;
  /// Distance [m] from the footprint to the nearest solid, 0 when they overlap; infinity without solids.
  double clearance(const Footprint& footprint, const Pose2D& pose) const;
  /// Distance [m] from a point to the nearest solid, 0 inside; infinity without solids.
  double clearance(Vec2 point) const;

 private:
  /// Holds every solid within `kReach` of the point, each once.
  const std::vector<int>& near(Vec2 point) const;

  static constexpr double kReach = 0.5;  // [m]
  std::vector<Solid> solids_;
  CellGrid<std::vector<int>> buckets_;
  std::vector<int> everything_;  // for points outside the buckets, and for far-away solids
};

}  // namespace threewe::scene
