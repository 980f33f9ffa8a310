// Covariance propagation of poses: of (x, y, theta), of a pose along the axes of the frame that it is in.
#pragma once

#include "core/exact.hpp"
#include "slam/pose_filter.hpp"
#include "threewe/core/pose.hpp"

namespace threewe::slam {

/// Of a pose of `c` in `a`, when those of `b` in `a` and of `c` in `b` are independent.
inline Matrix3 composed(const Pose2D& a_from_b, const Matrix3& of_b, const Pose2D& b_from_c, const Matrix3& of_c) {
  const auto [s, c] = exact::sincos(a_from_b.theta);
  const Vec2 arm{c * b_from_c.x - s * b_from_c.y, s * b_from_c.x + c * b_from_c.y};
  Matrix3 by_b = Matrix3::Identity();
  by_b(kX, kTheta) = -arm.y;
  by_b(kY, kTheta) = arm.x;
  Matrix3 by_c;
  by_c << c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0;
  return by_b * of_b * by_b.transpose() + by_c * of_c * by_c.transpose();
}

/// The same along other axes, that are turned by `angle` [rad] clockwise.
inline Matrix3 rotated(const Matrix3& covariance, double angle) {
  return composed({0.0, 0.0, angle}, Matrix3::Zero(), {}, covariance);
}

}  // namespace threewe::slam
