// Speed limits of zones for velocities that no planner made.
#pragma once

#include <span>

#include "threewe/core/pose.hpp"
#include "threewe/hardware/profile.hpp"
#include "threewe/map/zone.hpp"

namespace threewe {

/// A velocity in the body frame, so slow that the body enters no zone faster than is allowed there, and none to keep
/// out of: it stops before these, and goes on only where that leads no nearer. A robot that is in one may leave it.
Velocity within_zones(const RobotProfile& robot, std::span<const map::Zone> zones, const Pose2D& map_from_base,
                      const Velocity& velocity);

}  // namespace threewe
