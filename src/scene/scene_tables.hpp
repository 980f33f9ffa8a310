// Precomputed tables of a scene for one robot: where it can be, and how far it is from place to place.
#pragma once

#include <cstdint>
#include <memory>

#include "scene/geodesic.hpp"
#include "scene/obstacles.hpp"
#include "scene/occupancy.hpp"
#include "threewe/core/footprint.hpp"
#include "threewe/scene/scene.hpp"

namespace threewe::scene {

/// A scene as a robot of some footprint and height meets it. Const and shared. Everything is in the scene's frame.
class SceneTables {
 public:
  /// `robot_height` [m]: what is entirely above it is no obstacle. Throws ConfigError when the robot can't stand at the
  /// scene's first start.
  SceneTables(std::shared_ptr<const Scene> scene, Footprint footprint, double robot_height);

  const Scene& scene() const { return *scene_; }
  const Footprint& footprint() const { return footprint_; }
  const Obstacles& obstacles() const { return obstacles_; }

  /// Cells that an obstacle reaches into.
  const CellSet& occupied() const { return occupied_; }
  /// Half the width [m] of the narrowest gap that the footprint fits through.
  double passing_radius() const { return passing_radius_; }
  /// Cells that the base can pass: at least the passing radius away from all obstacles.
  const CellSet& passable() const { return passable_; }
  /// Passable cells that are connected with the first start.
  const CellSet& reachable() const { return reachable_; }
  /// Indices of reachable cells where the footprint and 5 cm around it are free in every heading.
  const std::vector<std::size_t>& roomy() const { return roomy_; }

  bool collides(const Pose2D& pose) const { return obstacles_.collides(footprint_, pose); }
  /// Distance [m] between the footprint and the nearest obstacle.
  double clearance(const Pose2D& pose) const { return obstacles_.clearance(footprint_, pose); }
  /// The length of the shortest path [m] over passable cells; infinity where there is none. Builds a field: keep
  /// `geodesic_field` where one target is asked for often.
  double geodesic(Vec2 from, Vec2 to) const;
  /// Lengths to one target, solved up to `limit` [m]. Refers to these tables.
  GeodesicField geodesic_field(Vec2 target, double limit = std::numeric_limits<double>::infinity()) const;
  /// A pose, reachable from the first start, where the footprint and 5 cm around it are free in every heading:
  /// uniform over roomy cells, and in heading. A pure function of the seed.
  Pose2D sample_free_pose(std::uint64_t seed) const;

 private:
  std::shared_ptr<const Scene> scene_;
  Footprint footprint_;
  double passing_radius_;
  Obstacles obstacles_;
  CellSet occupied_;
  CellSet passable_;
  CellSet reachable_;
  std::vector<std::size_t> roomy_;
};

}  // namespace threewe::scene
