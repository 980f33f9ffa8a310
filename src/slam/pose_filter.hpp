// How sure we are of the pose and of the sensors' systematic errors, and how they hang together.
#pragma once

#include <Eigen/Core>

#include "threewe/core/pose.hpp"
#include "threewe/slam/scan_matching_localizer.hpp"

namespace threewe::slam {

using Matrix3 = Eigen::Matrix<double, 3, 3>;
using Vector3 = Eigen::Matrix<double, 3, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

/// The covariance of an extended Kalman filter over (x, y, theta, gyro bias, forward scale, lateral scale). Its mean
/// lives elsewhere: the pose in `map_from_odom`, the rest in `Calibration`; updates return by how much it shifts.
class PoseFilter {
 public:
  explicit PoseFilter(const SensorModel& sensors);

  /// Grows with one step of dead reckoning. `heading`: in `map`, half way through the step.
  void predict(double heading, Vec2 step, double turn, double seconds, bool gyro);
  /// The pose was estimated afresh from this prediction and a scan: it shifted by `shift` and now has covariance
  /// `posterior`. Returns the shift of everything, the pose's included.
  Vector6 condition_on_pose(const Vector3& shift, const Matrix3& posterior);
  /// The robot stands: the gyro measures its bias. Returns the shift of everything.
  Vector6 observe_gyro_bias(double error, double variance);
  /// Admits that the pose may be far off.
  void widen(double position_sigma, double heading_sigma);

  const Matrix6& covariance() const { return covariance_; }
  Matrix3 pose_covariance() const { return covariance_.topLeftCorner<3, 3>(); }

 private:
  SensorModel sensors_;
  Matrix6 covariance_ = Matrix6::Zero();
};

}  // namespace threewe::slam
