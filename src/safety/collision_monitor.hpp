// Collision monitor: keeps the footprint clear of obstacle points.
#pragma once

#include <span>

#include "safety/gate.hpp"

namespace threewe::safety {

/// The command nearest to `command`, on the way from braking along the present arc, after which the robot can still
/// stop with the margin free. `command` is within reach of the period before; so is what comes back. `base` is where
/// the robot is in the frame of the obstacles.
Velocity clear_of_obstacles(const GateModel& model, const GateState& state, const Velocity& command,
                            std::span<const Vec2> obstacles, const Pose2D& base);

}  // namespace threewe::safety
