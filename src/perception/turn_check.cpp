#include "perception/turn_check.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <utility>

#include "core/exact.hpp"

namespace threewe::perception {
namespace {

constexpr double kRise = 1.1;         // of the median with each number ...
constexpr double kRiseAtFirst = 1.4;  // ... and with so many first ones
constexpr int kFirst = 32;
constexpr double kLeastNoise = 1e-4;   // [rad/s]
constexpr double kMedian = 0.6744898;  // of a normal number's size, in deviations

double seconds_between(Time from, Time to) { return to_seconds(to - from); }

}  // namespace

NoiseEstimator::NoiseEstimator(double sigma) : median_(kMedian * exact::sqrt(6.0) * std::max(sigma, kLeastNoise)) {}

void NoiseEstimator::add(double value) {
  const double bend = value - 2.0 * before_[0] + before_[1];
  before_ = {value, before_[0]};
  count_ = std::min(count_ + 1, kFirst);
  if (count_ < 3) return;
  const double rise = count_ < kFirst ? kRiseAtFirst : kRise;
  median_ = std::fabs(bend) > median_ ? median_ * rise : median_ / rise;
  median_ = std::max(median_, kMedian * exact::sqrt(6.0) * kLeastNoise);
}

double NoiseEstimator::sigma() const { return median_ / (kMedian * exact::sqrt(6.0)); }

TurnCheck::TurnCheck(const RobotProfile& profile, const Params::Turn& params)
    : params_(params), gyro_noise_(profile.imu ? profile.imu->gyro_sigma : 0.0), wheel_noise_(params.sigma) {
  const WheelGeometry& wheels = profile.body.wheels;
  // each wheel's radius is off by a share that is uniform within the bounds; they may well have worn beyond those
  const double scale = params.wear * std::numbers::inv_sqrt3 * profile.odometry.wheel_scale;
  const double per_speed =
      std::max(scale, params_.least_scale) /
      (exact::sqrt(static_cast<double>(wheels.wheel_count())) * (wheels.half_length + wheels.half_width));
  const double bias = std::max(params_.zero_offset, params.wear * (profile.imu ? profile.imu->gyro_bias : 0.0));
  const Factors sigma = {per_speed, per_speed, scale + 0.02, bias, params_.lag};
  for (std::size_t i = 0; i < kFactors; ++i) variance_[i][i] = sigma[i] * sigma[i];
}

void TurnCheck::add_gyro(Time measured, double rate) {
  const double seconds = turned_.empty() ? 0.0 : seconds_between(turned_.back().at, measured);
  if (turned_.empty() || seconds <= 0.0 || seconds > params_.longest_step) {  // what was before has no end
    turned_.assign(1, Turned{measured});
    return;
  }
  gyro_noise_.add(rate);
  const Turned& last = turned_.back();
  turned_.push_back({measured, last.angle + seconds * rate, last.samples + 1});
  const Time oldest = complete_ ? complete_->begin : window_ ? window_->begin : measured;
  while (turned_.size() > 2 && turned_[1].at <= oldest) turned_.pop_front();
}

std::optional<double> TurnCheck::add_odometry(Time measured, const Odometry& odometry) {
  const double seconds = window_ ? seconds_between(window_->end, measured) : 0.0;
  if (!window_ || seconds <= 0.0 || seconds > params_.longest_step) {
    window_ = Window{.begin = measured, .end = measured, .before = odometry.velocity, .after = odometry.velocity};
  } else {
    extend(*window_, measured, odometry);
  }
  wheels_ = odometry;
  if (window_->seconds >= params_.window) {
    complete_ = window_;
    window_ = Window{.begin = measured, .end = measured, .before = odometry.velocity, .after = odometry.velocity};
  }
  if (!complete_ || turned_.empty() || turned_.back().at < complete_->end) return std::nullopt;
  const Window window = *std::exchange(complete_, std::nullopt);
  return judge(window);
}

void TurnCheck::extend(Window& window, Time measured, const Odometry& odometry) {
  const double seconds = seconds_between(window.end, measured);
  const double turned = wrap_angle(odometry.pose.theta - wheels_.pose.theta);
  const Velocity& v = odometry.velocity;
  const Factors motion = {v.vx, v.vy, v.omega, 1.0, 0.0};
  wheel_noise_.add(turned / seconds);
  for (std::size_t i = 0; i < kFactors; ++i) window.moved[i] += seconds * motion[i];
  window.angle += turned;
  window.seconds += seconds;
  ++window.samples;
  window.end = measured;
  window.after = v;
}

// Between two samples the gyro turned evenly.
std::optional<TurnCheck::Turned> TurnCheck::turned_until(Time at) const {
  const auto after = std::ranges::lower_bound(turned_, at, {}, &Turned::at);
  if (after == turned_.end() || (after == turned_.begin() && after->at != at)) return std::nullopt;
  if (after->at == at) return *after;
  const Turned& before = *std::prev(after);
  const double share = seconds_between(before.at, at) / seconds_between(before.at, after->at);
  return Turned{at, before.angle + share * (after->angle - before.angle), after->samples};
}

std::optional<double> TurnCheck::judge(const Window& window) {
  const auto begun = turned_until(window.begin);
  const auto ended = turned_until(window.end);
  if (!begun || !ended || ended->samples <= begun->samples) return std::nullopt;

  Factors motion = window.moved;
  for (double& m : motion) m /= window.seconds;
  const double change = window.after.omega - window.before.omega;
  motion[4] = change / window.seconds;
  const double push = exact::hypot(window.after.vx - window.before.vx, window.after.vy - window.before.vy);
  const double jerk = params_.jerk_sigma * std::fabs(change) + params_.push_sigma * push;
  const double gyro = gyro_noise_.sigma();
  const double wheels = wheel_noise_.sigma();
  const double noise = jerk * jerk + gyro * gyro / static_cast<double>(ended->samples - begun->samples) +
                       wheels * wheels / static_cast<double>(window.samples);
  return innovation(motion, (ended->angle - begun->angle - window.angle) / window.seconds, noise);
}

// One step of recursive least squares.
double TurnCheck::innovation(const Factors& motion, double difference, double noise) {
  Factors gain{};
  double expected = 0.0;
  const double turn = params_.turn_sigma * motion[2];
  double variance = params_.sigma * params_.sigma + turn * turn + noise;
  for (std::size_t i = 0; i < kFactors; ++i) {
    expected += factors_[i] * motion[i];
    for (std::size_t j = 0; j < kFactors; ++j) gain[i] += variance_[i][j] * motion[j];
    variance += motion[i] * gain[i];
  }
  const double off = difference - expected;
  const double normalised = off / exact::sqrt(variance);
  if (std::fabs(normalised) < params_.learnable) {
    for (std::size_t i = 0; i < kFactors; ++i) factors_[i] += gain[i] / variance * off;
    for (std::size_t i = 0; i < kFactors; ++i) {
      for (std::size_t j = 0; j < kFactors; ++j) variance_[i][j] -= gain[i] * gain[j] / variance;
      if (i < 3) variance_[i][i] += params_.walk;
      if (i == 3) variance_[i][i] += 0.1 * params_.walk;
    }
  }
  const double before = std::exchange(last_, normalised);
  if (std::fabs(off) < params_.small) return 0.0;
  const bool again =
      std::fabs(normalised) > params_.twice && std::fabs(before) > params_.twice && normalised * before > 0.0;
  return again ? normalised + before : normalised;
}

}  // namespace threewe::perception
