// Scan-matching localizer: localization and mapping by wheels, gyro and lidar.
#pragma once

#include <memory>

#include "threewe/core/pose.hpp"
#include "threewe/slam/localizer.hpp"

namespace threewe::slam {

/// How good the sensors are.
struct SensorModel {
  bool lidar = true;  ///< without one, wheels and gyro are all there is
  Pose2D base_from_lidar;
  double gyro_sigma = 0.002;          ///< [rad/s] of one sample
  double gyro_bias_sigma = 0.005;     ///< [rad/s] of the bias at the start
  double gyro_bias_walk = 1e-4;       ///< [rad/s/sqrt(s)]
  double wheel_drift = 0.0;           ///< [rad/sqrt(m)] of the heading, where wheels alone tell it
  double wheel_slip = 0.0;            ///< [m/sqrt(m)] of the position, beyond what good wheels have
  double range_sigma = 0.01;          ///< [m] of the scatter of one range
  double range_bias_sigma = 0.017;    ///< [m] of the lidar's constant error
  double forward_scale_sigma = 0.01;  ///< of true over measured motion ahead
  double lateral_scale = 1.0;         ///< expected true over measured motion sideways
  double lateral_scale_sigma = 0.0;
};

/// Scan-to-map localisation on top of dead reckoning, see `src/slam/scan_matching_localizer.cpp` for the story. A robot
/// that is lost looks for itself in the whole map: in the one that was given, or in its own.
std::unique_ptr<Localizer> make_scan_matching_localizer(const SensorModel& sensors, const InitialState& initial = {});

}  // namespace threewe::slam
