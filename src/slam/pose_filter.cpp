#include "slam/pose_filter.hpp"

#include <cmath>

#include <Eigen/LU>

namespace threewe::slam {
namespace {

// Random errors of dead reckoning beyond its systematic ones; variances grow with the distance and the angle.
constexpr double kForwardSlip = 0.015;   // [m/sqrt(m)]
constexpr double kLateralSlip = 0.03;    // [m/sqrt(m)]
constexpr double kTurnSlip = 0.01;       // [m/sqrt(rad)] the base wanders while it turns
constexpr double kGyroScale = 0.002;     // [rad/sqrt(rad)]
constexpr double kWheelTurn = 0.05;      // [rad/sqrt(rad)] when the wheels alone tell the heading
constexpr double kScaleWalk = 1e-4;      // [1/sqrt(m)]

double square(double x) { return x * x; }

}  // namespace

PoseFilter::PoseFilter(const SensorModel& sensors) : sensors_(sensors) {
  covariance_(3, 3) = square(sensors.gyro_bias);
  covariance_(4, 4) = square(sensors.forward_scale_sigma);
  covariance_(5, 5) = square(sensors.lateral_scale_sigma);
}

void PoseFilter::predict(double heading, Vec2 step, double turn, double seconds, bool gyro) {
  const auto [s, c] = exact::sincos(heading);
  const Vec2 moved{c * step.x - s * step.y, s * step.x + c * step.y};

  // the step turns with the heading and stretches with the scales; the heading turns back with the bias
  Matrix6 f = Matrix6::Identity();
  f(0, 2) = -moved.y;
  f(1, 2) = moved.x;
  f(0, 4) = c * step.x;
  f(1, 4) = s * step.x;
  f(0, 5) = -s * step.y;
  f(1, 5) = c * step.y;
  if (gyro) f(2, 3) = -seconds;
  covariance_ = (f * covariance_ * f.transpose()).eval();

  const double distance = norm(step);
  const double angle = std::fabs(turn);
  const double along = square(kForwardSlip) * distance + square(kTurnSlip) * angle;
  const double across = square(kLateralSlip) * distance + square(kTurnSlip) * angle;
  covariance_(0, 0) += c * c * along + s * s * across;
  covariance_(1, 1) += s * s * along + c * c * across;
  covariance_(0, 1) += c * s * (along - across);
  covariance_(1, 0) = covariance_(0, 1);
  covariance_(2, 2) += gyro ? square(kGyroScale) * angle + square(sensors_.gyro_sigma) * 0.01 * seconds
                            : square(kWheelTurn) * angle;
  covariance_(3, 3) += square(sensors_.gyro_bias_walk) * seconds;
  covariance_(4, 4) += square(kScaleWalk) * distance;
  covariance_(5, 5) += sensors_.lateral_scale_sigma > 0.0 ? square(kScaleWalk) * distance : 0.0;
}

Vector6 PoseFilter::condition_on_pose(const Vector3& shift, const Matrix3& posterior) {
  // what is correlated with the pose follows it: gain = P_all,pose * P_pose,pose^-1
  const Matrix3 prior = pose_covariance();
  const Eigen::Matrix<double, 6, 3> gain = covariance_.leftCols<3>() * prior.inverse();
  const Vector6 all = gain * shift;
  covariance_ -= (gain * (prior - posterior) * gain.transpose()).eval();
  covariance_ = (0.5 * (covariance_ + covariance_.transpose())).eval();
  return all;
}

Vector6 PoseFilter::observe_gyro_bias(double error, double variance) {
  const Vector6 gain = covariance_.col(3) / (covariance_(3, 3) + variance);
  covariance_ -= (gain * covariance_.row(3)).eval();
  covariance_ = (0.5 * (covariance_ + covariance_.transpose())).eval();
  return gain * error;
}

void PoseFilter::widen(double position_sigma, double heading_sigma) {
  covariance_(0, 0) += square(position_sigma);
  covariance_(1, 1) += square(position_sigma);
  covariance_(2, 2) += square(heading_sigma);
}

}  // namespace threewe::slam
