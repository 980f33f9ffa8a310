#include "slam/dead_reckoning.hpp"

#include <algorithm>
#include <cmath>

namespace threewe::slam {
void DeadReckoning::add_gyro(Time stamp, double rate) {
  if (has_gyro_) {
    const double gap = to_seconds(stamp - gyro_stamp_);
    const double seconds = std::clamp(gap, 0.0, to_seconds(params_.sample_age));
    heading_ += seconds * rate;  // a sample is the mean since the one before
    if (gap > to_seconds(params_.sample_age) && count_ > 0) {
      // wheels gave the heading meanwhile, up to their newest sample
      const double since = std::clamp(to_seconds(stamp - point(0).stamp), -to_seconds(params_.sample_age),
                                      to_seconds(params_.sample_age));
      heading_used_ = heading_ - since * rate;
    }
  }
  has_gyro_ = true;
  gyro_stamp_ = stamp;
  gyro_rate_ = rate;
}

void DeadReckoning::add_odometry(Time stamp, const Odometry& odometry) {
  TrackPoint next;
  next.stamp = stamp;
  const double heading = gyro_heading(stamp);
  const bool gyro_fresh = has_gyro_ && std::fabs(to_seconds(stamp - gyro_stamp_)) <= to_seconds(params_.sample_age);
  const double rate = gyro_fresh ? gyro_rate_ - calibration_.gyro_bias : odometry.velocity.omega;
  next.by_gyro = gyro_fresh;
  next.velocity = {calibration_.forward_scale * odometry.velocity.vx, calibration_.lateral_scale * odometry.velocity.vy,
                   rate};

  if (count_ > 0) {
    const TrackPoint& last = point(0);
    if (stamp <= last.stamp) return;
    next.seconds = to_seconds(stamp - last.stamp);

    const Pose2D moved = inverse(wheels_.pose) * odometry.pose;
    next.standing = moved == Pose2D{} ? last.standing + 1 : 0;
    rolled_ = rolled_ || next.standing == 0;
    if (scans_follow_ && next.seconds > to_seconds(params_.extrapolation)) {
      // it has gone on as was guessed, and scans have corrected that
      next.odom_from_base = at(stamp);
      const Pose2D guessed = inverse(last.odom_from_base) * next.odom_from_base;
      next.step = rotate(guessed.position(), -0.5 * guessed.theta);
      next.turn = next.rolled = guessed.theta;
      next.measured = next.turn + next.seconds * calibration_.gyro_bias;
    } else {
      // the wheels' own chord, seen from half way through their turn, is what they rolled
      const Vec2 rolled = rotate(moved.position(), -0.5 * moved.theta);
      next.step = {calibration_.forward_scale * rolled.x, calibration_.lateral_scale * rolled.y};
      next.measured = heading - heading_used_;
      next.turn = gyro_fresh ? next.measured - next.seconds * calibration_.gyro_bias : moved.theta;
      next.rolled = moved.theta;
      const double middle = last.odom_from_base.theta + 0.5 * next.turn;
      const Vec2 position = last.odom_from_base.position() + rotate(next.step, middle);
      next.odom_from_base = {position.x, position.y, wrap_angle(last.odom_from_base.theta + next.turn)};
    }
  }
  heading_used_ = heading;
  wheels_ = odometry;
  points_[count_ % kCapacity] = next;
  ++count_;
}

Pose2D DeadReckoning::at(Time stamp) const {
  if (count_ == 0) return {};
  const TrackPoint& newest = point(0);
  if (stamp >= newest.stamp) {
    const double ahead = std::min(to_seconds(stamp - newest.stamp), to_seconds(params_.extrapolation));
    return integrate(newest.odom_from_base, newest.velocity, ahead);
  }
  for (std::size_t age = 1; age < size(); ++age) {
    const TrackPoint& before = point(age);
    if (stamp < before.stamp) continue;
    const TrackPoint& after = point(age - 1);
    const double t = to_seconds(stamp - before.stamp) / to_seconds(after.stamp - before.stamp);
    return interpolate(before.odom_from_base, after.odom_from_base, t);
  }
  return point(size() - 1).odom_from_base;
}

MotionSummary DeadReckoning::between(Time from, Time to) const {
  MotionSummary sum;
  sum.at_rest = true;
  double turned = 0.0;
  double apart = 0.0;
  Pose2D guessed;
  const auto guess = [&](const TrackPoint& last, Time until) {
    if (!scans_follow_) return;  // the next pose tells of that time
    const Duration unseen = until - std::max(last.stamp + params_.sample_age, from);
    if (unseen > 0ns) guessed = integrate(guessed, last.velocity, to_seconds(unseen));
  };
  for (std::size_t age = size(); age-- > 0;) {
    const TrackPoint& p = point(age);
    if (p.stamp <= from || p.stamp > to) continue;
    if (age + 1 < size()) guess(point(age + 1), p.stamp);
    turned += p.turn;
    sum.measured += p.measured;
    sum.seconds += p.seconds;
    sum.at_rest = sum.at_rest && p.by_gyro && (p.standing >= params_.standing_samples || !rolled_);
    apart += p.turn - p.rolled;
  }
  if (!empty()) guess(point(0), to);
  sum.doubtful_way = norm(guessed.position());
  const double usual = params_.disagreement + params_.turning_disagreement * std::fabs(turned);
  sum.doubtful_turn = std::fabs(guessed.theta) + std::max(0.0, std::fabs(apart) - usual);
  return sum;
}

bool DeadReckoning::stands() const { return empty() || point(0).standing >= params_.standing_samples; }

double DeadReckoning::gyro_heading(Time stamp) const {
  const double ahead =
      std::clamp(to_seconds(stamp - gyro_stamp_), -to_seconds(params_.sample_age), to_seconds(params_.sample_age));
  return heading_ + ahead * gyro_rate_;
}

}  // namespace threewe::slam
