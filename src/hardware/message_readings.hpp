// Readings of messages whose fields have the same names in ROS 2 and in Gazebo.
#pragma once

#include <cmath>
#include <optional>
#include <string>

#include <tl/expected.hpp>

#include "core/exact.hpp"
#include "threewe/core/samples.hpp"

namespace threewe {

/// The heading of a rotation; empty for four numbers that are none.
template <typename Quaternion>
std::optional<double> heading_of(const Quaternion& q) {
  const double norm = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
  if (!std::isfinite(norm) || norm < 0.5 || norm > 2.0) return std::nullopt;
  return wrap_angle(exact::atan2(2.0 * (q.w * q.z + q.x * q.y), q.w * q.w + q.x * q.x - q.y * q.y - q.z * q.z));
}

/// Of an angular velocity [rad/s] and an acceleration [m/s^2]; or what is wrong with them.
template <typename Vector>
tl::expected<IMUData, std::string> imu_data_of(const Vector& w, const Vector& a) {
  for (const double value : {w.x, w.y, w.z, a.x, a.y, a.z}) {
    if (!std::isfinite(value)) return tl::unexpected<std::string>("a rate or an acceleration is not finite");
  }
  return IMUData{{w.x, w.y, w.z}, {a.x, a.y, a.z}};
}

/// Of a pose and a twist; or what is wrong with them.
template <typename Pose, typename Twist>
tl::expected<Odometry, std::string> odometry_of(const Pose& pose, const Twist& twist) {
  const auto theta = heading_of(pose.orientation);
  if (!theta) return tl::unexpected<std::string>("the orientation is no unit quaternion");
  const Odometry data{{pose.position.x, pose.position.y, *theta}, {twist.linear.x, twist.linear.y, twist.angular.z}};
  if (!is_finite(data.pose) || !is_finite(data.velocity)) {
    return tl::unexpected<std::string>("a pose or a velocity is not finite");
  }
  return data;
}

}  // namespace threewe
