// Detector of blind sectors of a lidar.
#pragma once

#include <optional>
#include <vector>

#include "perception/params.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/samples.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe::perception {

/// Directions in which no beam is valid, counter-clockwise, in the base frame.
struct BlindSector {
  double from = 0.0;  ///< [rad]
  double to = 0.0;    ///< [rad]
};

/// Looks for invalid beams side by side, so many that the robot would fit between the valid ones beside them at the
/// distance in which it stops. No return is a valid reading; a few beams that drop out leave no such gap; and what is
/// nearer than the lidar can measure makes honest ones, which begin or end at its least range, or where something was
/// seen that came nearer.
class BlindCheck {
 public:
  BlindCheck() = default;
  /// Of a robot that has a lidar.
  explicit BlindCheck(const RobotProfile& profile, const Params::Blind& params = {});

  /// The widest sector in which this scan is blind. `at`: where the robot is by its wheels.
  std::optional<BlindSector> check(const LaserScan& scan, const Pose2D& at);

 private:
  std::vector<bool> remember_near(const LaserScan& scan, const Pose2D& odom_from_lidar);

  Params::Blind params_;
  Pose2D base_from_lidar_;
  double least_ = 0.0;      // [rad] the narrowest sector in which the robot would fit
  double near_gap_ = 0.0;   // [m] ranges beside something that is too near
  std::vector<Vec2> near_;  // in odom [m], what is or was hardly farther
};

}  // namespace threewe::perception
