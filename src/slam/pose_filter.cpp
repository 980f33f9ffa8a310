#include "slam/pose_filter.hpp"
#include "core/exact.hpp"
#include "core/numbers.hpp"

#include <cmath>

#include <Eigen/LU>

namespace threewe::slam {
namespace {

constexpr double kLeastRangeSigma = 1e-6;  // [m] keeps the covariance invertible for a lidar without bias

}  // namespace

PoseFilter::PoseFilter(const SensorModel& sensors, const Params::Filter& params) : sensors_(sensors), params_(params) {
  covariance_(kRangeBias, kRangeBias) = square(sensors.range_bias_sigma);
  covariance_(kGyroBias, kGyroBias) = square(sensors.gyro_bias_sigma);
  covariance_(kForwardScale, kForwardScale) = square(sensors.forward_scale_sigma);
  covariance_(kLateralScale, kLateralScale) = square(sensors.lateral_scale_sigma);
}

void PoseFilter::predict(double heading, Vec2 step, double turn, double seconds, bool gyro) {
  const auto [s, c] = exact::sincos(heading);
  const Vec2 moved{c * step.x - s * step.y, s * step.x + c * step.y};

  // the step turns with the heading and stretches with the scales; the heading turns back with the bias
  Matrix7 f = Matrix7::Identity();
  f(kX, kTheta) = -moved.y;
  f(kY, kTheta) = moved.x;
  f(kX, kForwardScale) = c * step.x;
  f(kY, kForwardScale) = s * step.x;
  f(kX, kLateralScale) = -s * step.y;
  f(kY, kLateralScale) = c * step.y;
  if (gyro) f(kTheta, kGyroBias) = -seconds;
  covariance_ = (f * covariance_ * f.transpose()).eval();

  const double distance = norm(step);
  const double angle = std::fabs(turn);
  const double slip = square(sensors_.wheel_slip) * distance + square(params_.turn_slip) * angle;
  const double along = params_.forward_slip * distance + slip;
  const double across = params_.lateral_slip * distance + slip;
  covariance_(kX, kX) += c * c * along + s * s * across;
  covariance_(kY, kY) += s * s * along + c * c * across;
  covariance_(kX, kY) += c * s * (along - across);
  covariance_(kY, kX) = covariance_(kX, kY);
  covariance_(kTheta, kTheta) += gyro
                                     ? square(params_.gyro_scale) * angle + square(sensors_.gyro_sigma) * 0.01 * seconds
                                     : square(params_.wheel_turn) * angle + square(sensors_.wheel_drift) * distance;
  if (sensors_.range_bias_sigma > 0.0) covariance_(kRangeBias, kRangeBias) += params_.range_walk * distance;
  covariance_(kGyroBias, kGyroBias) += square(sensors_.gyro_bias_walk) * seconds;
  covariance_(kForwardScale, kForwardScale) += square(params_.scale_walk) * distance;
  if (sensors_.lateral_scale_sigma > 0.0)
    covariance_(kLateralScale, kLateralScale) += square(params_.scale_walk) * distance;
}

Vector7 PoseFilter::condition(const Vector4& shift, const Matrix4& posterior, const std::optional<Vec2>& unobserved) {
  // what is correlated with the four follows them: gain = P_all,four * P_four,four^-1
  const Matrix4 prior = scan_covariance();
  const Matrix4 learned = prior - posterior;
  const Eigen::Matrix<double, 7, 4> gain = covariance_.leftCols<4>() * prior.inverse();
  covariance_ -= (gain * learned * gain.transpose()).eval();
  Vector7 shifts = gain * shift;
  if (unobserved) {  // considered, not estimated (Schmidt 1966): its variance stays, what it makes of others shrinks
    Matrix7 left_alone = Matrix7::Zero();
    const Eigen::Vector2d along(unobserved->x, unobserved->y);
    left_alone.topLeftCorner<2, 2>() = along * along.transpose();
    left_alone(kForwardScale, kForwardScale) = left_alone(kLateralScale, kLateralScale) = 1.0;
    const Eigen::Matrix<double, 7, 4> undone = left_alone * gain;
    covariance_ += (undone * learned * undone.transpose()).eval();
    shifts -= undone * shift;
  }
  covariance_ = (0.5 * (covariance_ + covariance_.transpose())).eval();
  return shifts;
}

Vector7 PoseFilter::observe_gyro_bias(double error, double variance) {
  const Vector7 gain = covariance_.col(kGyroBias) / (covariance_(kGyroBias, kGyroBias) + variance);
  covariance_ -= (gain * covariance_.row(kGyroBias)).eval();
  covariance_ = (0.5 * (covariance_ + covariance_.transpose())).eval();
  return gain * error;
}

void PoseFilter::restart(double position_sigma, double heading_sigma) {
  covariance_.topRows<3>().setZero();
  covariance_.leftCols<3>().setZero();
  widen(position_sigma, heading_sigma);
}

void PoseFilter::widen(double position_sigma, double heading_sigma) {
  covariance_(kX, kX) += square(position_sigma);
  covariance_(kY, kY) += square(position_sigma);
  covariance_(kTheta, kTheta) += square(heading_sigma);
  widen_range_bias(kLeastRangeSigma);
}

void PoseFilter::widen_range_bias(double sigma) { covariance_(kRangeBias, kRangeBias) += square(sigma); }

}  // namespace threewe::slam
