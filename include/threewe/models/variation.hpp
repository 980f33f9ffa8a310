// One draw of a domain randomization: how one robot differs from its profile. Plain data.
#pragma once

#include <cstdint>
#include <type_traits>

#include "threewe/core/pose.hpp"

namespace threewe::models {

/// The default is the profile itself. Factors multiply what the profile says.
struct Variation {
  // the body and its drive
  double mass = 1.0;                ///< factor; the moment of inertia grows with it
  double friction = 1.0;            ///< factor of wheels on the floor
  double motor_lag = 1.0;           ///< factor of the speed loop's time constant
  double motor_noise = 0.0;         ///< standard deviation of each motor's torque in each step, as a share of it
  double battery_charge = 1.0;      ///< at the start, 0 to 1
  double battery_resistance = 1.0;  ///< factor, hence of how far the voltage sags

  // sensors
  double lidar_noise = 1.0;      ///< factor of range noise and of the unit's bias
  double lidar_dropout = 1.0;    ///< factor of the probability that a point is invalid
  double imu_noise = 1.0;        ///< factor of noise and of biases
  double camera_noise = 1.0;     ///< factor of noise, of colours and of depth
  double odometry_slip = 1.0;    ///< factor of how far wheels and lateral rolling are from what odometry assumes
  double command_latency = 1.0;  ///< factor, rounded to whole steps
  double sensor_latency = 1.0;   ///< factor of the lidar's and the camera's latency, rounded to whole steps

  // what the camera sees, and from where
  double light = 1.0;         ///< factor of the brightness of lamps and sun
  double exposure = 1.0;      ///< factor of what the camera makes of it
  double color_jitter = 0.0;  ///< standard deviation of each colour channel's gain
  double texture = 0.0;       ///< 0: surfaces as the scene has them; else which others they are made of, a whole number
  Pose2D camera_offset{};     ///< of the camera from its mount, in the base frame
  double camera_height = 0.0;  ///< [m] added to the mount's

  friend bool operator==(const Variation&, const Variation&) = default;
};
static_assert(std::is_trivially_copyable_v<Variation>);
static_assert(sizeof(Variation) % sizeof(double) == 0);

}  // namespace threewe::models
