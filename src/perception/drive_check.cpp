#include "perception/drive_check.hpp"

#include <algorithm>
#include <cmath>

#include "core/exact.hpp"

namespace threewe::perception {
namespace {

double speed(const Velocity& v) { return exact::hypot(v.vx, v.vy); }

// [m] standard deviation of the place, in a direction in the base frame.
double sigma_along(const slam::PoseEstimate& estimate, Vec2 in_base) {
  const Vec2 d = rotate(in_base, estimate.map_from_base().theta);
  const auto& c = estimate.covariance;
  return exact::sqrt(std::max(0.0, d.x * (c[0] * d.x + c[1] * d.y) + d.y * (c[3] * d.x + c[4] * d.y)));
}

Velocity sum_of(const Velocity& a, const Velocity& b, const Velocity& less = {}) {
  return {a.vx + b.vx - less.vx, a.vy + b.vy - less.vy, a.omega + b.omega - less.omega};
}

}  // namespace

DriveCheck::DriveCheck(const RobotProfile& profile, const Params::Drive& params)
    : params_(params), base_(profile.body.wheels), motor_limit_(params.motor_limit * profile.body.no_load_speed) {
  const Duration reaction = profile.command_latency + profile.body.motor_lag;
  const auto periods = [](Duration duration) {
    return std::min(kMostDelay, static_cast<std::size_t>((duration + kControlPeriod / 2) / kControlPeriod));
  };
  delay_ = periods(reaction);
  latest_ = periods(from_seconds(params.latest * to_seconds(reaction)));
}

bool DriveCheck::is_disobeyed(const Velocity& command, const Velocity& wheels) {
  commands_[count_ % commands_.size()] = command;
  wheels_[count_ % kWindow] = wheels;
  ++count_;
  if (count_ < commands_.size()) return false;

  Velocity done;
  Velocity commanded;
  for (std::size_t i = 0; i < kWindow; ++i) {
    done = sum_of(done, wheels_[i]);
    commanded = sum_of(commanded, this->command(i));
  }
  // a link or a motor may be slower than the data sheet says: what follows a command at any delay obeys it
  for (std::size_t delay = 0; !obeys(commanded, done); ++delay) {
    if (delay == latest_) return true;
    commanded = sum_of(commanded, this->command(delay + kWindow), this->command(delay));
  }
  return false;
}

bool DriveCheck::obeys(const Velocity& commands, const Velocity& turns) const {
  const Velocity done = mean_of(turns);
  const Velocity commanded = attainable(mean_of(commands), done);
  return exact::hypot(done.vx - commanded.vx, done.vy - commanded.vy) <=
             params_.speed_off + params_.share_off * speed(commanded) &&
         std::fabs(done.omega - commanded.omega) <= params_.turn_off + params_.share_off * std::fabs(commanded.omega);
}

Velocity DriveCheck::attainable(const Velocity& commanded, const Velocity& done) const {
  WheelSpeeds speeds = wheel_speeds(base_, commanded);
  const WheelSpeeds turned = wheel_speeds(base_, done);
  bool limited = false;
  for (std::size_t i = 0; i < speeds.size(); ++i) {
    const bool same_way = speeds[i] * turned[i] > 0.0;
    if (!same_way || std::fabs(turned[i]) < motor_limit_ || std::fabs(turned[i]) > std::fabs(speeds[i])) continue;
    speeds[i] = turned[i];
    limited = true;
  }
  return limited ? body_velocity(base_, speeds) : commanded;
}

bool DriveCheck::commanded_to_stand() const {
  for (std::size_t i = 0; i < std::min(count_, delay_ + static_cast<std::size_t>(params_.settling)); ++i) {
    if (command(i) != Velocity{}) return false;
  }
  return true;
}

bool DriveCheck::commanded_to_drive() const {
  const std::size_t since = delay_ + static_cast<std::size_t>(params_.settling);
  if (count_ < since) return false;
  for (std::size_t i = 0; i < since; ++i) {
    const Velocity& c = command(i);
    if (speed(c) < params_.driving && std::fabs(c.omega) < params_.driving_turn) return false;
  }
  return true;
}

bool WayCheck::is_contradicted(const slam::PoseEstimate& estimate) {
  if (!corrected_) corrected_ = estimate;
  if (estimate.map_from_odom == corrected_->map_from_odom) return false;

  const Vec2 way = (inverse(corrected_->odom_from_base) * estimate.odom_from_base).position();
  const Pose2D predicted = corrected_->map_from_odom * estimate.odom_from_base;
  const Vec2 by = (inverse(predicted) * estimate.map_from_base()).position();
  const double turned = wrap_angle(estimate.odom_from_base.theta - corrected_->odom_from_base.theta);
  corrected_ = estimate;
  const double length = norm(way);
  if (length < params_.least_way) return false;
  // the correction is in the base frame, which has turned since
  const double along = dot(rotate(by, turned), way) / length;
  shares_[count_ % kCorrections] = along / length;
  corrections_[count_++ % kCorrections] = along;
  if (count_ < kCorrections) return false;
  double sum = 0.0;
  for (const double correction : corrections_) sum += correction;
  // along a bare corridor scans tell nothing, and what they correct is noise
  if (std::fabs(sum) < params_.significance * sigma_along(estimate, (1.0 / length) * way)) return false;

  std::array<double, kCorrections> sorted = shares_;
  std::ranges::nth_element(sorted, sorted.begin() + kCorrections / 2);
  const double share = sorted[kCorrections / 2];
  if (share > -params_.taken_back && share < params_.added) return false;
  count_ = 0;  // begin anew
  return true;
}

}  // namespace threewe::perception
