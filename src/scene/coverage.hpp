// Coverage meter: how much of a place a robot has really seen and mapped.
#pragma once

#include <functional>
#include <memory>

#include "scene/scene_tables.hpp"

namespace threewe::scene {

inline constexpr double kCoverageRange = 8.0;  ///< [m]
/// What there is to cover: the 5 cm cells that no obstacle reaches into and whose middle a disc of the robot's passing
/// radius can cover, coming from the first start.
CellSet coverable_cells(const SceneTables& tables);

/// Measures the coverage of an exploration: the share of all coverable cells that a noise-free ray from the true pose
/// crossed within `kCoverageRange` *and* that the robot's own map marks free within 10 cm.
class CoverageMeter {
 public:
  /// `lidar_height` [m]: the plane in which rays are cast.
  CoverageMeter(std::shared_ptr<const SceneTables> tables, double lidar_height);

  /// Casts 360 rays from the lidar's true place in the scene; the first along its heading.
  void observe(const Pose2D& scene_from_lidar);
  /// The share of reachable cells, 0 to 1, that were crossed and are marked free. `is_free` tells whether the robot's
  /// map marks a point of the scene free.
  double coverage(const std::function<bool(Vec2)>& is_free) const;
  /// The share of reachable cells, 0 to 1, that were crossed.
  double crossed() const;

  const CellSet& reachable_cells() const { return reachable_; }
  const CellSet& crossed_cells() const { return crossed_; }

 private:
  std::shared_ptr<const SceneTables> tables_;
  Slice slice_;
  CellSet reachable_;
  CellSet crossed_;
};

}  // namespace threewe::scene
