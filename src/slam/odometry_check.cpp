#include "slam/odometry_check.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/LU>

#include "core/bounds.hpp"
#include "core/exact.hpp"

namespace threewe::slam {
namespace {

// Odometry that jumps says nothing about how the robot moves.
Velocity mean_velocity(const Pose2D& step, double seconds) {
  const Vec2 rolled = rotate(step.position(), -0.5 * step.theta);
  const Velocity mean{rolled.x / seconds, rolled.y / seconds, step.theta / seconds};
  const bool jumped = norm({mean.vx, mean.vy}) > kMaxSpeed || std::fabs(mean.omega) > kMaxSpeed;
  return jumped ? Velocity{} : mean;
}

}  // namespace

// One scan: carry the belief to it by the motion that it supports, fit it to the last metres.
Registration OdometryCheck::add(FrontEnd& front, const map::LogOddsMap* map, Time stamp, const LaserScan& scan,
                                double range_max, const std::optional<Pose2D>& odom_from_base) {
  const bool first = front.track().empty();
  std::optional<Pose2D> step;
  if (odom_from_base) step = raw_ ? (*raw_ == *odom_from_base ? Pose2D{} : inverse(*raw_) * *odom_from_base) : Pose2D{};
  raw_ = odom_from_base;
  if (step && !first && !is_bounded(front.track().odometry().pose * *step)) step = Pose2D{};
  const Pose2D before = first ? Pose2D{} : front.map_from_base();
  const double seconds = first ? 0.0 : to_seconds(stamp - front.stamp());
  const std::optional<Pose2D> stated = step;
  if (step) step = rescaled(*step);

  Registration seen;
  if (repeats(scan, step.value_or(Pose2D{}), seen)) {
    seen.scan = Registration::Scan::repeated;
    follow(front, {nullptr, stamp, scan, range_max}, {step.value_or(Pose2D{})});
  } else {
    const bool related = register_scan(front, {map, stamp, scan, range_max}, step, seen);
    if (map != nullptr) judge(front, related, seen);
    const bool fits = map != nullptr && seen.scan == Registration::Scan::fits && !seen.odometry_jumped;
    compare(front, before, fits && !seen.odometry_stopped ? stated : std::nullopt);
    seen.odometry_scaled = is_scaled();
  }
  moved_ = inverse(before) * front.map_from_base();
  moved_seconds_ = seconds;
  return seen;
}

// A scan that equals the one before to the bit was not measured: the robot stands in a world without noise, or its
// lidar has stopped, which shows when it drives on.
bool OdometryCheck::repeats(const LaserScan& scan, const Pose2D& step, Registration& seen) {
  const auto is_hit = [&](float range) { return range > 0.0F && static_cast<double>(range) < scan.range_max; };
  const bool same = ranges_ == scan.ranges && std::ranges::any_of(ranges_, is_hit);
  if (!same) {
    ranges_ = scan.ranges;
    frozen_step_ = {};
    return false;
  }
  const Params::OdometryCheck& p = params_->odometry_check;
  frozen_step_ = frozen_step_ * step;
  seen.frozen = norm(frozen_step_.position()) > p.frozen_distance || std::fabs(frozen_step_.theta) > p.frozen_turn;
  return true;
}

// Fits the scan where odometry leads; where that is doubtful, where the motion so far leads, too. Returns whether it is
// related to the scans before at all.
bool OdometryCheck::register_scan(FrontEnd& front, const View& view, const std::optional<Pose2D>& step,
                                  Registration& seen) {
  const Motion steady = steady_motion(front, view.stamp);
  const bool stands = step && *step == Pose2D{};
  odometry_stopped_ = odometry_stopped_ && stands;
  seen.odometry_stopped = odometry_stopped_;
  if (!step || odometry_stopped_) {
    follow(front, view, steady);
    return view.map == nullptr || front.is_confirmed(front.newest_match());
  }
  const FrontEnd before = front;
  const Params::OdometryCheck& p = params_->odometry_check;
  const double seconds = before.track().empty() ? 1.0 : to_seconds(view.stamp - before.stamp());
  const Pose2D off = inverse(steady.step) * *step;
  const double metres = norm(off.position());
  const double turn = std::fabs(off.theta);
  const bool jumps = metres > p.jump || turn > p.turn_jump;
  const bool impossible = jumps && std::max(metres / p.most_speed, turn / p.most_turn_rate) >
                                       std::max(seconds, to_seconds(p.shortest_interval));
  follow(front, view, {*step});
  if (view.map == nullptr) return true;

  FrontEnd other = before;
  if (stands && has_moved(front, *view.map)) {
    odometry_stopped_ = seen.odometry_stopped = true;
    follow(other, view, steady);
    front = std::move(other);
    return true;
  }
  const bool confirmed = front.is_confirmed(front.newest_match());
  const bool doubtful = jumps || !front.fits() || (stands && !confirmed);
  if (doubtful) follow(other, view, steady);
  if (doubtful && is_better(front, other, impossible)) {
    odometry_stopped_ = seen.odometry_stopped = stands;
    seen.odometry_jumped = !stands;
    front = std::move(other);
    return true;
  }
  if (!impossible || confirmed) return true;
  front = std::move(other);
  return false;
}

// Two accounts of the motion: whether the scan supports the one without odometry.
bool OdometryCheck::is_better(const FrontEnd& by_odometry, const FrontEnd& steady, bool impossible) const {
  const Match& with = by_odometry.newest_match();
  const Match& without = steady.newest_match();
  const bool better = with.known_hits >= params_->registration.few_hits &&
                      without.agreement > with.agreement + params_->registration.better_poor;
  return steady.is_confirmed(without) && (better || impossible || !by_odometry.fits());
}

// A step of odometry whose distances have lately been too long or too short by one factor, as scans measured it. Turns
// are left as they are: odometry's heading drifts by much more than by a factor.
Pose2D OdometryCheck::rescaled(const Pose2D& step) const {
  const Vec2 moved = is_scaled() ? driven_.ratio() * step.position() : step.position();
  return {moved.x, moved.y, step.theta};
}

bool OdometryCheck::is_scaled() const {
  const Params::OdometryCheck& p = params_->odometry_check;
  return driven_.stated >= p.scale_distance && std::fabs(driven_.ratio() - 1.0) > p.scaled;
}

// Takes in a step from a pose. Scans that leave a direction open count as if they moved as odometry did, so the step
// counts only where they do not. `step`: empty where it is not to be compared.
void OdometryCheck::compare(const FrontEnd& front, const Pose2D& before, const std::optional<Pose2D>& step) {
  const Params::OdometryCheck& p = params_->odometry_check;
  const Match& match = front.newest_match();
  if (!step || !front.is_confirmed(match) || match.unobserved) {
    stated_ = measured_ = {};
    return;
  }
  stated_ = stated_ * *step;
  measured_ = measured_ * (inverse(before) * front.map_from_base());
  const double metres = norm(stated_.position());
  if (metres < p.compared_distance) return;
  const double kept = 1.0 / (1.0 + metres / (2.0 * p.scale_distance));
  driven_.stated = kept * driven_.stated + metres;
  driven_.measured = kept * driven_.measured + dot(measured_.position(), stated_.position()) / metres;
  stated_ = measured_ = {};
}

// The robot goes on as it did from the scan before the last to the last.
OdometryCheck::Motion OdometryCheck::steady_motion(const FrontEnd& front, Time stamp) const {
  if (front.track().empty()) return {};
  const Params::OdometryCheck& p = params_->odometry_check;
  Pose2D step;
  if (moved_seconds_ > 0.0) {
    const double times = to_seconds(stamp - front.stamp()) / moved_seconds_;
    step = integrate({}, mean_velocity(moved_, 1.0), std::min(times, p.most_extrapolation));
  }
  return {step, p.steady_distance + p.steady_share * norm(step.position()),
          p.steady_turn + p.steady_share * std::fabs(step.theta)};
}

// Carries the belief along a motion, and matches the scan there.
void OdometryCheck::follow(FrontEnd& front, const View& view, const Motion& motion) const {
  const DeadReckoning& track = front.track();
  const double seconds = track.empty() ? 0.0 : to_seconds(view.stamp - front.stamp());
  front.add_odometry(view.stamp, {track.odometry().pose * motion.step,
                                  seconds > 0.0 ? mean_velocity(motion.step, seconds) : Velocity{}});
  front.predict_to(view.stamp);
  front.add_scan(view.stamp, view.scan, view.stamp, view.range_max);
  if (view.map == nullptr) return;
  front.match(*view.map, {.position = motion.position_sigma, .heading = motion.heading_sigma});
  if (front.fits()) front.update();
}

// Odometry has the robot stand: is that where its scan lies, when nothing but the scan counts?
bool OdometryCheck::has_moved(const FrontEnd& front, const map::LogOddsMap& map) const {
  if (!front.is_confirmed(front.newest_match())) return false;
  const Params::OdometryCheck& p = params_->odometry_check;
  const Pose2D here = front.map_from_base();
  const Match free = front.match_alone(map);
  const Vector3 off(free.at.pose.x - here.x, free.at.pose.y - here.y, wrap_angle(free.at.pose.theta - here.theta));
  const bool far = off.head<2>().norm() > p.moved || std::fabs(off.z()) > p.turned;
  return far && front.is_confirmed(free) && off.dot(free.scan_information.topLeftCorner<3, 3>() * off) > p.moved_chi;
}

// What is to become of the scan, which may be related to those before or not. One that agrees with the map much less
// than scans of this lidar do is elsewhere, too.
void OdometryCheck::judge(const FrontEnd& front, bool related, Registration& seen) {
  const Params::OdometryCheck& p = params_->odometry_check;
  const Match& match = front.newest_match();
  const bool known = match.known_hits >= params_->registration.few_hits;
  const bool unusual = known && match.agreement < p.least_of_usual * usual_agreement_;
  if (related && front.fits() && !unusual) {
    misfits_ = 0;
    if (known) usual_agreement_ += p.usual_share * (match.agreement - usual_agreement_);
    return;
  }
  seen.scan = Registration::Scan::misfit;
  ++misfits_;
  const bool at_once = !related && raw_.has_value();
  const bool many = front.hits() >= params_->registration.few_hits;
  if (!many || (!at_once && misfits_ < params_->odometry_check.most_misfits)) return;
  seen.scan = Registration::Scan::lost;
  misfits_ = 0;
}

}  // namespace threewe::slam
