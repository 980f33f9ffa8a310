// Do wheels and gyro turn alike?
#pragma once

#include <array>
#include <optional>

#include "threewe/core/samples.hpp"
#include "threewe/core/time.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe::health {

/// The difference between the gyro's and the wheels' rates of turning, over windows of half a second. Wheels that are
/// not quite as large as assumed make a difference that is proportional to how the robot moves, and the gyro has a
/// bias: these four factors are estimated on the way, and what they do not explain is an innovation.
class TurnCheck {
 public:
  TurnCheck() = default;
  explicit TurnCheck(const RobotProfile& profile);

  void add_gyro(Time measured, double rate);
  /// A window that has ended with this sample: its innovation over its standard deviation, with that of the window
  /// before where both are large; 0 where it does no harm.
  std::optional<double> add_odometry(Time measured, const Odometry& odometry);

 private:
  using Vector4 = std::array<double, 4>;
  double innovation(const Vector4& motion, double difference, double jerk);

  Vector4 factors_{};                  // per vx, vy, omega and of itself
  std::array<Vector4, 4> variance_{};  // their covariance
  // the window
  std::optional<Time> gyro_stamp_;
  std::optional<Time> wheels_stamp_;
  Odometry wheels_;
  Velocity velocity_;          // at the end of the window before
  double gyro_angle_ = 0.0;    // [rad]
  double gyro_seconds_ = 0.0;  // [s] that it covers
  double wheel_angle_ = 0.0;
  double wheel_seconds_ = 0.0;
  double last_ = 0.0;  // its normalised innovation
  Vector4 moved_{};    // sums of velocity times time
};

}  // namespace threewe::health
