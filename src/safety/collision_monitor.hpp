// Collision monitor: keeps the footprint clear of obstacle points.
#pragma once

#include <span>

#include "safety/gate.hpp"

namespace threewe::safety {

/// Obstacle points of one kind.
struct Obstacles {
  std::span<const Vec2> points;  ///< [m]
  double margin = 0.0;           ///< [m] kept free around the footprint of these, at most the model's
  double depth = 0.0;            ///< [m] so far into the footprint may come what is measured to be inside already
};

/// The command nearest to `command`, on the way from braking along the present arc, after which the robot can still
/// stop with the margins free. `command` is within reach of the period before; so is what comes back. `base` is where
/// the robot is in the frame of the obstacles.
Velocity clear_of_obstacles(const GateModel& model, const GateState& state, const Velocity& command,
                            std::span<const Obstacles> obstacles, const Pose2D& base);

/// [m] From the base: what is farther away changes no decision of the period to come, whatever is requested, unless in
/// creep mode.
double sight_of_decision(const GateModel& model, const GateState& state);

}  // namespace threewe::safety
