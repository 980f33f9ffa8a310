// Forward and inverse kinematics of wheeled bases: four mecanum wheels, or a differential drive.
#pragma once

#include <array>
#include <cstdint>

#include "threewe/core/pose.hpp"

namespace threewe {

/// Which velocities a base can drive: all three, or none to the side.
enum class Kinematics : std::uint8_t { holonomic, differential };

/// Where the driven wheels are, how large and how heavy. Holonomic: mecanum wheels at (+-half_length, +-half_width).
/// Differential: two wheels at (0, +-half_width).
struct WheelGeometry {
  Kinematics kinematics = Kinematics::holonomic;  ///< four mecanum wheels, or two driven ones
  double radius = 0.0;                            ///< [m]
  double half_length = 0.0;                       ///< [m], from the base to an axle; 0 for differential
  double half_width = 0.0;                        ///< [m], from the base to a wheel's middle
  double width = 0.0;                             ///< [m] of a wheel, along its axle
  double mass = 0.0;                              ///< [kg] of one wheel, its rollers included
  int rollers = 0;  ///< on each mecanum wheel, at 45 degrees to its axle; 0 for differential
  friend bool operator==(const WheelGeometry&, const WheelGeometry&) = default;

  /// How many wheels are driven.
  constexpr int wheel_count() const { return kinematics == Kinematics::holonomic ? 4 : 2; }
};

/// Wheel speeds [rad/s]. Holonomic: front left, front right, rear left, rear right. Differential: left, right, 0, 0.
using WheelSpeeds = std::array<double, 4>;

/// The wheel speeds that roll without slip at `velocity`. `vy` is ignored on a differential base.
WheelSpeeds wheel_speeds(const WheelGeometry& wheels, const Velocity& velocity);
/// The body velocity that fits `speeds` best (least squares; exact without slip).
Velocity body_velocity(const WheelGeometry& wheels, const WheelSpeeds& speeds);

}  // namespace threewe
