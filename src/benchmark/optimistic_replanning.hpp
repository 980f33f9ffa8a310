// Optimistic-replanning baseline: drives in an unknown place as no robot can expect to beat.
#pragma once

#include "scene/scene_tables.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe::benchmark {

/// A drive as it could have been.
struct ReferenceDrive {
  bool reached = false;
  double length = 0.0;    ///< [m]
  double duration = 0.0;  ///< [s] at the speed limit, without any time to speed up, brake or turn
};

/// Drives from `start` to `goal`, both in the scene's frame, in a place of which nothing is known at first: with a
/// perfect pose and a lidar without noise, every 5 cm along a shortest path for the inscribed radius, where all that
/// has not been seen is taken to be free. An obstacle that no beam can meet is known once it is touched. People are not
/// there. Throws HardwareError for a robot without a lidar, ContractError for a start or a goal outside of
/// the scene.
ReferenceDrive optimistic_replanning(const scene::SceneTables& tables, const RobotProfile& profile, const Pose2D& start,
                                     Vec2 goal);

}  // namespace threewe::benchmark
