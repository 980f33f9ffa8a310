// A robot, larger or smaller in all its lengths, speeds and forces, while its times stay as they are. In a building
// scaled alike it sees the same, and should do the same.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "threewe/hardware/profile.hpp"

namespace threewe::testing {

inline Pose2D scaled(const Pose2D& pose, double by) { return {by * pose.x, by * pose.y, pose.theta}; }

inline Limits scaled(const Limits& limits, double by) {
  return {by * limits.linear, limits.angular, by * limits.linear_acceleration, by * limits.linear_braking,
          limits.angular_acceleration};
}

/// Of the same material: masses grow with the volume. Floors hold it as well, for its size.
inline Body scaled(Body body, double by) {
  const double volume = by * by * by;
  std::vector<Vec2> corners = body.footprint.corners();
  for (Vec2& corner : corners) corner = by * corner;
  body.footprint = Footprint(std::move(corners));
  body.height *= by;
  body.mass *= volume;
  body.inertia *= volume * by * by;
  WheelGeometry& wheels = body.wheels;
  for (double* length : {&wheels.radius, &wheels.half_length, &wheels.half_width, &wheels.width}) *length *= by;
  wheels.mass *= volume;
  for (Caster& caster : body.casters) caster.position = by * caster.position, caster.radius *= by;
  body.friction *= by;
  body.rolling_resistance *= by;
  body.stall_torque *= volume * by * by;
  return body;
}

/// `by` times as large and as fast, with sensors that are as much less exact.
inline RobotProfile scaled(RobotProfile profile, double by) {
  profile.body = scaled(profile.body, by);
  profile.hardware_limits = scaled(profile.hardware_limits, by);
  profile.operating_limits = scaled(profile.operating_limits, by);
  if (profile.lidar) {
    LidarSpec& lidar = *profile.lidar;
    lidar.base_from_lidar = scaled(lidar.base_from_lidar, by);
    for (double* length : {&lidar.height, &lidar.range_min, &lidar.range_max, &lidar.sigma, &lidar.bias}) *length *= by;
  }
  if (profile.ultrasonics) {
    UltrasonicSpec& sonar = *profile.ultrasonics;
    for (auto& mount : sonar.mounts) mount.base_from_ultrasonic = scaled(mount.base_from_ultrasonic, by);
    for (double* length : {&sonar.height, &sonar.range_min, &sonar.range_max, &sonar.sigma}) *length *= by;
  }
  profile.camera.reset();
  profile.yaml.clear();
  return profile;
}

}  // namespace threewe::testing
