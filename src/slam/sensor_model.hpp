// Sensor model of the SLAM front end: how good lidar, gyro and wheels are.
#pragma once

#include "threewe/core/pose.hpp"

namespace threewe::slam {

/// How good the sensors are.
struct SensorModel {
  bool lidar = true;    ///< without one, wheels and gyro are all there is
  bool gyro = true;     ///< without one, wheels alone measure turns
  bool streams = true;  ///< odometry arrives between scans; false: one pose with each scan, however rarely they come
  Pose2D base_from_lidar;
  double gyro_sigma = 0.002;          ///< [rad/s] of one sample
  double gyro_bias_sigma = 0.005;     ///< [rad/s] of the bias at the start
  double gyro_bias_walk = 1e-4;       ///< [rad/s/sqrt(s)]
  double wheel_drift = 0.0;           ///< [rad/sqrt(m)] of the heading, where wheels alone tell it
  double wheel_slip = 0.0;            ///< [m/sqrt(m)] of the position, beyond what good wheels have
  double range_sigma = 0.01;          ///< [m] noise of one range
  double range_bias_sigma = 0.017;    ///< [m] of the lidar's constant error
  int points_per_turn = 0;            ///< that the lidar measures, which may be more than it has beams; 0: not known
  double forward_scale_sigma = 0.01;  ///< of true over measured motion ahead
  double lateral_scale = 1.0;         ///< expected true over measured motion sideways
  double lateral_scale_sigma = 0.0;
};

}  // namespace threewe::slam
