// Vectorised drive step: motors and wheels of many robots at once.
#pragma once

#include <span>

#include "sim/model.hpp"
#include "sim/state.hpp"

namespace threewe::sim::kernel {

/// A robot as a step begins. (Plain numbers: arrays of these are scratch, and nothing sets them twice.)
struct Driver {
  const RobotModel* robot;
  RobotState* state;
  const Velocity* command;  ///< that arrives now; some number follows it in memory, whichever
  double floor;             ///< how well the floor holds
};

/// Where its wheels would take it, if nothing is in the way.
struct Driven {
  double x, y, theta;
  double vx, vy, omega;
  double max_collision_speed;
  double distance_driven;
  double carried_vx, carried_vy, carried_omega;
  double unused;

  Pose2D pose() const { return {x, y, theta}; }
  Velocity velocity() const { return {vx, vy, omega}; }
  /// Its velocity before its wheels pulled, seen from the heading that the step began with.
  Velocity carried() const { return {carried_vx, carried_vy, carried_omega}; }
};

/// Motors turn the wheels, the wheels pull the body, and the battery pays: takes what the states say of wheels and
/// battery one step on, and tells where the bodies would go. Which robots share a call changes no bit.
void drive(std::span<const Driver> drivers, std::span<Driven> driven);

/// All of these read their encoders.
void measure_odometry(std::span<const Driver> drivers);

}  // namespace threewe::sim::kernel
