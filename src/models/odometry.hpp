// Wheel-odometry model: encoders know what the wheels did, not what the body did.
#pragma once

#include <array>

#include "core/rng.hpp"
#include "threewe/core/kinematics.hpp"
#include "threewe/core/samples.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe::models {

/// How one robot differs from its nominal dimensions, drawn once per episode.
struct WheelErrors {
  std::array<double, 4> scale{1.0, 1.0, 1.0, 1.0};  ///< assumed radius over true radius of each wheel
  double lateral = 1.0;                             ///< of what the wheels roll sideways, the share that the body moves
};
/// `slip` is a factor of how far all of them are from nominal.
WheelErrors draw_wheel_errors(const OdometrySpec& spec, const RngKey& key, double slip = 1.0);

/// What an odometer is made of, worked out beforehand. V is double, or a vector of doubles: one robot's in each lane.
template <class V>
struct OdometerOf {
  V count;              ///< [rad] of an encoder; 0 of a perfect one
  V counts_per_radian;  ///< [1/rad]
  V per_period;         ///< [1/s]
  V roll;               ///< see DriveOf
  V roll_turn;
  V sideways;
};
using Odometer = OdometerOf<double>;

Odometer make_odometer(const OdometrySpec& spec, const WheelGeometry& wheels);

/// What an odometer carries from sample to sample. Plain data.
struct OdometryState {
  Odometry reading;              ///< the newest; its pose is in `odom`, which begins at (0, 0, 0)
  std::array<double, 4> read{};  ///< wheel angles as the encoders gave them at that time [rad]
};

/// Reads the encoders of wheels that have turned by `angles` [rad] since the episode began, and moves the odometer on.
void measure_odometry(const Odometer& odometer, const WheelErrors& errors, const std::array<double, 4>& angles,
                      OdometryState& state);

}  // namespace threewe::models
