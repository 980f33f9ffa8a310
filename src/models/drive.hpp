// Drive model, from a commanded velocity to the motion of the body: motors with lag and limited torque, wheels with
// limited friction.
#pragma once

#include <array>
#include <cstdint>

#include "core/rng.hpp"
#include "threewe/core/kinematics.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"
#include "threewe/hardware/profile.hpp"
#include "threewe/models/randomization.hpp"

namespace threewe::models {

inline constexpr double kGravity = 9.80665;  ///< [m/s^2]

/// What a drive is made of, worked out beforehand so that a step divides by nothing that stays the same. V is double,
/// or a vector of doubles: one robot's in each lane.
template <class V>
struct DriveOf {
  // how wheels move the body and the other way round
  V turns_per_metre;  ///< [rad/m]
  V turn_arm;         ///< [m] of the wheels about the base
  V sideways;         ///< 1 where wheels roll sideways too, on four of them; 0 on two that do not
  V roll;             ///< [m] that the body moves for each radian that one wheel turns
  V roll_turn;        ///< [rad] that it turns

  // the firmware clamps commands to these
  V linear_limit;   ///< [m/s]
  V angular_limit;  ///< [rad/s]

  V per_no_load_speed;    ///< [s/rad], at nominal voltage
  V turn_weight;          ///< [m], turns an angular velocity into the speed that takes as much force at the wheels
  V inertia_arm_squared;  ///< [m^2], inertia over mass
  V resistance;           ///< [m/s^2] of rolling
  V per_step;             ///< [1/s]
};

using Drive = DriveOf<double>;

Drive make_drive(const RobotProfile& profile, Duration step);

/// How hard one robot's motors and wheels pull: the part of a drive that a variation changes. Plain data.
struct Traction {
  double response = 0.0;         ///< the share of a speed error that the speed loop removes in one step
  double stall_change = 0.0;     ///< [rad/s] that stall torque adds to a wheel's speed in one step
  double friction_change = 0.0;  ///< [m/s] that friction can add to the body's speed in one step
  double mass = 0.0;             ///< [kg]
  double motor_noise = 0.0;      ///< standard deviation of each motor's torque in each step, as a share of it
  double turn_response = 0.0;    ///< as `response`, of turns; of wheels that spin freely alone, see `TractionModel`.hpp
};

Traction make_traction(const RobotProfile& profile, Duration step, const Variation& variation = {});

/// What each motor gives of its torque in one step, 1 on average: a pure function of the key, the step and the wheel.
std::array<double, 4> motor_shares(const Traction& traction, const RngKey& key, std::uint64_t step);

/// Wheel speeds after one step of the motors' speed loops towards `setpoints`. `supply` is the battery's voltage over
/// the nominal one: torque falls from stall to nothing at the no-load speed, both in proportion to it. A wheel
/// that turns faster than its motor's supply allows is braked, and so is every wheel without any. `shares` are of the
/// torque that comes of it.
WheelSpeeds drive_motors(const Drive& drive, const Traction& traction, const WheelSpeeds& speeds,
                         const WheelSpeeds& setpoints, double supply,
                         const std::array<double, 4>& shares = {1.0, 1.0, 1.0, 1.0});

/// The body's velocity after one step on wheels that roll at `rolling` (body frame).
///
/// The wheels pull the body to their own velocity, with no more force than friction gives: an ellipsoid in
/// (force, torque), the usual limit surface (Howe and Cutkosky 1996). Implicit, hence stable at any step, and it never
/// overshoots. `floor` is how well the floor holds: times the wheels' friction on a hard one.
Velocity limit_by_friction(const Drive& drive, const Traction& traction, const Velocity& body, const Velocity& rolling,
                           double floor = 1.0);

/// Mechanical power [W] that the wheels took to change the velocity from `before` to `after` while they rolled at
/// `rolling`: force times speed where it is made, so that wheels that spin are paid for; and what rolling resists with.
double drive_power(const Drive& drive, const Traction& traction, const Velocity& before, const Velocity& after,
                   const Velocity& rolling);

}  // namespace threewe::models
