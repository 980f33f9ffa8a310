// Consistency check of wheel odometry and gyro in turns.
#pragma once

#include <array>
#include <cstddef>
#include <deque>
#include <optional>

#include "perception/params.hpp"
#include "threewe/core/samples.hpp"
#include "threewe/core/time.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe::perception {

/// Estimator of the noise standard deviation of readings that change smoothly: how far each is off its neighbours,
/// by the median of second differences, which rises and falls by a tenth with each number.
class NoiseEstimator {
 public:
  NoiseEstimator() = default;
  explicit NoiseEstimator(double sigma);
  void add(double value);
  double sigma() const;

 private:
  double median_ = 0.0;
  std::array<double, 2> before_{};
  int count_ = 0;
};

/// The difference between the gyro's and the wheels' rates of turning, over windows of half a second: the same ones,
/// however late either arrives. Wheels that are not quite as large as assumed make a difference that is proportional to
/// how the robot moves, the gyro has a bias, and either may lag; these five factors are estimated on the way, as is how
/// much both scatter, and what they do not explain is an innovation.
class TurnCheck {
 public:
  TurnCheck() = default;
  explicit TurnCheck(const RobotProfile& profile, const Params::Turn& params = {});

  void add_gyro(Time measured, double rate);
  /// A window that both have gone beyond by now: its innovation over its standard deviation, with that of the window
  /// before where both are large; 0 where it does no harm.
  std::optional<double> add_odometry(Time measured, const Odometry& odometry);

 private:
  static constexpr std::size_t kFactors = 5;
  using Factors = std::array<double, kFactors>;
  /// How the gyro has turned up to a moment.
  struct Turned {
    Time at{};
    double angle = 0.0;       // [rad]
    std::size_t samples = 0;  // so far
  };
  /// A while by the wheels.
  struct Window {
    Time begin{};
    Time end{};
    double angle = 0.0;    // [rad]
    double seconds = 0.0;  // of these there is odometry
    std::size_t samples = 0;
    Velocity before;  // at its begin
    Velocity after;
    Factors moved{};  // sums of velocity times time
  };
  void extend(Window& window, Time measured, const Odometry& odometry);
  std::optional<double> judge(const Window& window);
  std::optional<Turned> turned_until(Time at) const;
  double innovation(const Factors& motion, double difference, double noise);

  Params::Turn params_;
  Factors factors_{};                         // per vx, vy, omega, of itself, and per change of omega
  std::array<Factors, kFactors> variance_{};  // their covariance
  NoiseEstimator gyro_noise_;                 // [rad/s] of each sample
  NoiseEstimator wheel_noise_;                // [rad/s]
  std::deque<Turned> turned_;                 // since the oldest window began
  std::optional<Window> window_;              // that goes on
  std::optional<Window> complete_;            // whose end the gyro has yet to reach
  Odometry wheels_;
  double last_ = 0.0;  // the newest normalised innovation
};

}  // namespace threewe::perception
