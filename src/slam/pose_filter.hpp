// Kalman filter of the pose and of the sensors' systematic errors.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "slam/params.hpp"
#include "slam/sensor_model.hpp"
#include "threewe/core/pose.hpp"

namespace threewe::slam {

using Matrix3 = Eigen::Matrix<double, 3, 3>;
using Vector3 = Eigen::Matrix<double, 3, 1>;
using Matrix4 = Eigen::Matrix<double, 4, 4>;
using Vector4 = Eigen::Matrix<double, 4, 1>;
using Matrix7 = Eigen::Matrix<double, 7, 7>;
using Vector7 = Eigen::Matrix<double, 7, 1>;

/// What is estimated. A scan tells the first four at once.
enum State : int { kX, kY, kTheta, kRangeBias, kGyroBias, kForwardScale, kLateralScale };

/// The covariance of an extended Kalman filter over `State`. Its mean lives elsewhere: the pose in `map_from_odom`, the
/// rest in `Calibration`; updates return by how much it shifts.
class PoseFilter {
 public:
  explicit PoseFilter(const SensorModel& sensors, const Params::Filter& params = {});

  /// Grows with one step of dead reckoning. `heading`: in `map`, half way through the step.
  void predict(double heading, Vec2 step, double turn, double seconds, bool gyro);
  /// Pose and range bias were estimated afresh from this prediction and a scan: they shifted by `shift` and now have
  /// covariance `posterior`. Returns the shift of everything, theirs included. Along `unobserved`, if there is such a
  /// direction, nothing is learned, nor are scales: what a wall beside the way tells of these, by how the robot nears
  /// it, is less than its map creeps.
  Vector7 condition(const Vector4& shift, const Matrix4& posterior, const std::optional<Vec2>& unobserved = {});
  /// The robot stands: the gyro measures its bias. Returns the shift of everything.
  Vector7 observe_gyro_bias(double error, double variance);
  /// The pose was given anew, so well. What is known of the sensors stays.
  void restart(double position_sigma, double heading_sigma);
  /// Admits that the pose may be far off.
  void widen(double position_sigma, double heading_sigma);
  /// The lidar may be biased by so much more [m].
  void widen_range_bias(double sigma);

  const Matrix7& covariance() const { return covariance_; }
  /// Of what a scan tells: pose and range bias.
  Matrix4 scan_covariance() const { return covariance_.topLeftCorner<4, 4>(); }

 private:
  SensorModel sensors_;
  Params::Filter params_;
  Matrix7 covariance_ = Matrix7::Zero();
};

}  // namespace threewe::slam
