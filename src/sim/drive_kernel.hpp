// The inner part of a step: how motors and wheels pull many robots, vectorised over robots.
#pragma once

#include <span>

#include "threewe/sim/model.hpp"
#include "threewe/sim/state.hpp"

namespace threewe::sim::kernel {

/// A robot as a step begins.
struct Driver {
  const RobotModel* robot = nullptr;
  RobotState* state = nullptr;
  Velocity command;    ///< that arrives now
  double floor = 1.0;  ///< how well the floor holds
};

/// Where its wheels would take it, if nothing is in the way.
struct Driven {
  Pose2D pose;
  Velocity velocity;
  double max_collision_speed = 0.0;
  double distance_driven = 0.0;
  Velocity carried;  ///< its velocity before its wheels pulled, seen from the heading that the step began with
  double unused = 0.0;
};

/// Motors turn the wheels, the wheels pull the body, and the battery pays: takes what the states say of wheels and
/// battery one step on, and tells where the bodies would go. Which robots share a call changes no bit.
void drive(std::span<const Driver> drivers, std::span<Driven> driven);

}  // namespace threewe::sim::kernel
