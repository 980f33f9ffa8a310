#include "robot/health/turn_check.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "threewe/core/exact.hpp"

namespace threewe::health {
namespace {

constexpr double kWindow = 0.4;       // [s]
constexpr double kMaxStep = 0.1;      // [s] a sample stands for no longer than this
constexpr double kSigma = 0.006;      // [rad/s] of the difference over a window, where nothing changes ...
constexpr double kTurnSigma = 0.01;   // ... more per rad/s of turning: wheels slip as they turn ...
constexpr double kJerkSigma = 0.015;  // ... and per rad/s by which the rate of turning changes: they never start as one
constexpr double kPushSigma = 0.015;  // [rad/s] per m/s by which the speed changes
constexpr double kWalk = 1e-5;        // [(rad/s)^2] by which the variances of the factors grow each window
constexpr double kSmall = 0.03;       // [rad/s] less than this does no harm
constexpr double kLearnable = 2.0;    // deviations: farther off is not learned from ...
constexpr double kTwice = 2.0;        // ... and counts for more when it comes twice

}  // namespace

TurnCheck::TurnCheck(const RobotProfile& profile) {
  const WheelGeometry& wheels = profile.body.wheels;
  // each wheel's radius is off by a share that is uniform within the bounds; they may well have worn beyond those
  const double scale = 1.5 * std::numbers::inv_sqrt3 * profile.odometry.wheel_scale;
  const double per_speed =
      scale / (exact::sqrt(static_cast<double>(wheels.wheel_count())) * (wheels.half_length + wheels.half_width));
  const double bias = 1.5 * (profile.imu ? profile.imu->gyro_bias : 0.0) + 1e-3;
  const std::array<double, 4> sigma = {per_speed, per_speed, scale + 0.02, bias};
  for (std::size_t i = 0; i < 4; ++i) variance_[i][i] = sigma[i] * sigma[i];
}

void TurnCheck::add_gyro(Time measured, double rate) {
  if (gyro_stamp_) {
    const double seconds = to_seconds(measured - *gyro_stamp_);
    if (seconds > 0.0 && seconds <= kMaxStep) {
      gyro_angle_ += seconds * rate;
      gyro_seconds_ += seconds;
    }
  }
  gyro_stamp_ = measured;
}

std::optional<double> TurnCheck::add_odometry(Time measured, const Odometry& odometry) {
  if (wheels_stamp_) {
    const double seconds = to_seconds(measured - *wheels_stamp_);
    if (seconds > 0.0 && seconds <= kMaxStep) {
      const Velocity& v = odometry.velocity;
      const Vector4 motion = {v.vx, v.vy, v.omega, 1.0};
      wheel_angle_ += wrap_angle(odometry.pose.theta - wheels_.pose.theta);
      wheel_seconds_ += seconds;
      for (std::size_t i = 0; i < 4; ++i) moved_[i] += seconds * motion[i];
    }
  }
  wheels_stamp_ = measured;
  wheels_ = odometry;
  if (wheel_seconds_ < kWindow) return std::nullopt;

  std::optional<double> result;
  if (std::fabs(gyro_seconds_ - wheel_seconds_) < 0.1 * kWindow) {
    Vector4 motion = moved_;
    for (double& m : motion) m /= wheel_seconds_;
    const double jerk =
        kJerkSigma * std::fabs(odometry.velocity.omega - velocity_.omega) +
        kPushSigma * exact::hypot(odometry.velocity.vx - velocity_.vx, odometry.velocity.vy - velocity_.vy);
    result = innovation(motion, gyro_angle_ / gyro_seconds_ - wheel_angle_ / wheel_seconds_, jerk);
  }
  gyro_angle_ = gyro_seconds_ = wheel_angle_ = wheel_seconds_ = 0.0;
  moved_ = {};
  velocity_ = odometry.velocity;
  return result;
}

// One step of recursive least squares.
double TurnCheck::innovation(const Vector4& motion, double difference, double jerk) {
  Vector4 gain{};
  double expected = 0.0;
  const double turn = kTurnSigma * motion[2];
  double variance = kSigma * kSigma + turn * turn + jerk * jerk;
  for (std::size_t i = 0; i < 4; ++i) {
    expected += factors_[i] * motion[i];
    for (std::size_t j = 0; j < 4; ++j) gain[i] += variance_[i][j] * motion[j];
    variance += motion[i] * gain[i];
  }
  const double off = difference - expected;
  const double normalised = off / exact::sqrt(variance);
  if (std::fabs(normalised) < kLearnable) {
    for (std::size_t i = 0; i < 4; ++i) factors_[i] += gain[i] / variance * off;
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < 4; ++j) variance_[i][j] -= gain[i] * gain[j] / variance;
      variance_[i][i] += i == 3 ? 0.1 * kWalk : kWalk;
    }
  }
  const double before = std::exchange(last_, normalised);
  if (std::fabs(off) < kSmall) return 0.0;
  const bool again = std::fabs(normalised) > kTwice && std::fabs(before) > kTwice && normalised * before > 0.0;
  return again ? normalised + before : normalised;
}

}  // namespace threewe::health
