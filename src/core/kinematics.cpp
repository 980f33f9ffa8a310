#include "threewe/core/kinematics.hpp"

namespace threewe {

// Mecanum wheels with rollers at 45 degrees in the usual X arrangement, seen from above (Taheri et al. 2015).
WheelSpeeds wheel_speeds(const WheelGeometry& wheels, const Velocity& velocity) {
  const auto [vx, vy, omega] = velocity;
  const double r = wheels.radius;
  if (wheels.kinematics == Kinematics::differential) {
    const double turn = wheels.half_width * omega;
    return {(vx - turn) / r, (vx + turn) / r, 0.0, 0.0};
  }
  const double turn = (wheels.half_length + wheels.half_width) * omega;
  return {(vx - vy - turn) / r, (vx + vy + turn) / r, (vx + vy - turn) / r, (vx - vy + turn) / r};
}

Velocity body_velocity(const WheelGeometry& wheels, const WheelSpeeds& speeds) {
  const double r = wheels.radius;
  if (wheels.kinematics == Kinematics::differential) {
    return {0.5 * r * (speeds[0] + speeds[1]), 0.0, 0.5 * r * (speeds[1] - speeds[0]) / wheels.half_width};
  }
  const double arm = wheels.half_length + wheels.half_width;
  return {0.25 * r * (speeds[0] + speeds[1] + speeds[2] + speeds[3]),
          0.25 * r * (-speeds[0] + speeds[1] + speeds[2] - speeds[3]),
          0.25 * r * (-speeds[0] + speeds[1] - speeds[2] + speeds[3]) / arm};
}

}  // namespace threewe
