// Nearest-frontier exploration baseline.
#pragma once

#include <memory>

#include "scene/scene_tables.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe::benchmark {

/// An exploration as it could have been.
struct ReferenceExploration {
  double coverage = 0.0;  ///< as scene::CoverageMeter has it
  double length = 0.0;    ///< [m]
  double duration = 0.0;  ///< [s] at the speed limit, until no frontier is left
};

/// Drives to the nearest frontier (Yamauchi 1997) until none can be reached: with a perfect pose and a lidar without
/// noise, along shortest paths, without any time to speed up, brake or turn. `start` in the scene's frame. People are
/// not there. Throws HardwareError for a robot without a lidar, ContractError for a start outside of the scene.
ReferenceExploration nearest_frontier(const std::shared_ptr<const scene::SceneTables>& tables,
                                      const RobotProfile& profile, const Pose2D& start);

}  // namespace threewe::benchmark
