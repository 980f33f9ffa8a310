#include "nav/path_follower.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/exact.hpp"
#include "nav/polyline.hpp"
#include "safety/params.hpp"

namespace threewe::nav {
namespace {

// Deviations from the straight way to the target that are tried when it is not free [rad].
constexpr std::array<double, 12> kFan = {0.2, -0.2, 0.4, -0.4, 0.6, -0.6, 0.9, -0.9, 1.2, -1.2, 1.6, -1.6};

constexpr double kTurnStep = 0.1;  // [rad] between the poses that are tried
constexpr int kLookaheads = 8;     // each a ninth less than the first

// Robots without a lidar detect late, and not always, what is ahead: they drive slowly.
Limits tracking_limits(const RobotProfile& profile, double blind_speed) {
  Limits limits = profile.operating_limits;
  if (!profile.lidar) limits.linear = std::min(limits.linear, blind_speed);
  return limits;
}

Velocity scaled(const Velocity& v, double s) { return {s * v.vx, s * v.vy, s * v.omega}; }

// The speed from which braking comes to rest within `way`, after the reaction.
double speed_to_stop(double way, double braking, double reaction) {
  return braking * (exact::sqrt(reaction * reaction + 2.0 * std::max(way, 0.0) / braking) - reaction);
}

// The poses of a constant motion, each a step after the one before, as far as they are asked for.
class Motion {
 public:
  explicit Motion(const Pose2D& step) : step_(step) {}
  // A point in the base frame of the beginning in that after `n` more steps than one.
  Vec2 in_base(Vec2 point, int n) {
    while (poses_.size() <= static_cast<std::size_t>(n)) go_on();
    const Placed& at = poses_[static_cast<std::size_t>(n)];
    const Vec2 d = point - at.pose.position();
    return {at.heading.cos * d.x + at.heading.sin * d.y, at.heading.cos * d.y - at.heading.sin * d.x};
  }

 private:
  struct Placed {
    Pose2D pose;
    exact::SinCos heading;
  };
  void go_on() {
    const Pose2D pose = poses_.empty() ? Pose2D{} * step_ : poses_.back().pose * step_;
    poses_.push_back({pose, exact::sincos(pose.theta)});
  }
  Pose2D step_;
  std::vector<Placed> poses_;
};

}  // namespace

Outline::Outline(const Footprint& footprint) {
  const std::vector<Vec2>& corners = footprint.corners();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2 d = corners[(i + 1) % corners.size()] - corners[i];
    const double length = norm(d);
    const Vec2 normal{d.y / length, -d.x / length};
    edges_.push_back({normal, dot(normal, corners[i])});
  }
}

double Outline::clearance(Vec2 p) const {
  double most = -std::numeric_limits<double>::infinity();
  for (const Edge& e : edges_) most = std::max(most, dot(e.normal, p) - e.offset);
  return most;
}

PathFollower::PathFollower(const RobotProfile& profile, const Params& params)
    : params_(params.follower),
      creep_(params.creep),
      limits_(tracking_limits(profile, params_.blind_speed)),
      kinematics_(profile.kinematics()),
      outline_(profile.body.footprint),
      mppi_(profile.lidar ? std::optional(Mppi(profile, params)) : std::nullopt),
      radius_(profile.body.footprint.circumscribed_radius()),
      full_speed_(profile.operating_limits.linear),
      margin_(safety::margin_of(profile)),
      inside_(profile.lidar ? profile.lidar->bias : 0.0) {}

void PathFollower::update(std::span<const Vec2> obstacles_in_base, double spare) {
  spare_ = spare;
  // beside corners an outline's clearance is less than the distance
  reach_ = radius_ + 2.0 * (margin_ + std::max(spare, 0.0)) + params_.horizon * full_speed_;
  near_.clear();
  least_.clear();
  for (const Vec2 p : obstacles_in_base) {
    if (dot(p, p) > reach_ * reach_) continue;
    near_.push_back(p);
    const double now = outline_.clearance(p);
    least_.push_back(std::min(margin_ + spare, now > 0.0 ? std::max(now - creep_.encroachment, 0.0) : now));
  }
}

Velocity PathFollower::follow(std::span<const Vec2> path, const MppiObservation& seen) {
  if (path.empty()) return {};
  if (kinematics_ == Kinematics::differential) {
    const PathPoint here = nearest_on_path(path, seen.odom_from_base.position());
    const Vec2 ahead = inverse(seen.odom_from_base) * point_after(path, here, params_.faced);
    const double bearing = exact::atan2(ahead.y, ahead.x);
    if (faces_first(bearing)) return face(bearing);
  }
  // a plan takes what it sees for fixed; what comes towards the robot unannounced needs more room than that
  const Velocity planned = mppi_->step(seen, {.path = path, .margin = margin_ + spare_ - inside_});
  return scaled(planned, allowed_fraction(planned, inside_));
}

Velocity PathFollower::pursue(std::span<const Vec2> path, const map::Costmap& costmap, const Pose2D& pose,
                              double aside) {
  if (path.empty()) return {};
  const PathPoint here = nearest_on_path(path, pose.position());
  const double left = length_after(path, here);

  // as far ahead as a straight line to the path stays clear of obstacles
  Vec2 target = path.back();
  for (int i = 0; i < kLookaheads; ++i) {
    target = point_after(path, here, params_.lookahead - params_.lookahead / (kLookaheads + 1) * i);
    if (std::isfinite(costmap.line_cost(pose.position(), target))) break;
  }
  const Vec2 in_base = inverse(pose) * target;
  return towards(in_base, std::max(creep_.speed, speed_before(left)), aside);
}

// Straight to the target where that is free, else along the direction of the fan that brings most.
Velocity PathFollower::towards(Vec2 target, double speed_limit, double aside) {
  const double bearing = exact::atan2(target.y, target.x);
  const double away = norm(target);
  const double speed = std::min(speed_limit, limits_.linear);

  const auto velocity_along = [&](double direction) -> Velocity {
    const double rate = std::clamp(params_.heading_gain * (direction + aside), -limits_.angular, limits_.angular);
    if (kinematics_ == Kinematics::holonomic) {
      // sideways motion is the least certain, so it is slow while the robot turns into its path
      const double share = std::clamp(1.3 - std::fabs(direction) / 1.2, 0.35, 1.0);
      return {share * speed * exact::cos(direction), share * speed * exact::sin(direction), rate};
    }
    const double curvature = 2.0 * exact::sin(direction) / std::max(away, params_.lookahead / 3.0);
    const double slow = std::min(speed, 0.9 * limits_.angular / std::max(std::fabs(curvature), 1e-6));
    const double omega = std::clamp(slow * curvature, -limits_.angular, limits_.angular);
    return {slow * std::max(exact::cos(direction), 0.0), 0.0, omega};
  };

  if (kinematics_ == Kinematics::differential && faces_first(bearing)) return face(bearing);

  const Velocity direct = velocity_along(bearing);
  const double direct_share = allowed_fraction(direct);
  if (direct_share >= 0.9) return scaled(direct, direct_share);

  Velocity best = scaled(direct, direct_share);
  double best_gain = direct_share * 1.1;
  for (const double deviation : kFan) {
    const Velocity v = velocity_along(wrap_angle(bearing + deviation));
    const double share = allowed_fraction(v);
    const double gain = share * exact::cos(deviation);
    if (gain > best_gain) best_gain = gain, best = scaled(v, share);
  }
  return best;
}

// A differential base turns on the spot towards what is not ahead, until it is.
bool PathFollower::faces_first(double bearing) {
  if (turning_ == 0 && std::fabs(bearing) > params_.turn_first) turning_ = bearing > 0.0 ? 1 : -1;
  if (std::fabs(bearing) < params_.turn_done) turning_ = 0;
  if (turning_ == 0) turned_back_ = 0;
  return turning_ != 0;
}

// The turn keeps its direction, even the long way round, and changes it only where something is in the way.
Velocity PathFollower::face(double bearing) {
  const auto turned = [&](int direction) -> Velocity {
    const double left = direction * bearing > 0.0 ? std::fabs(bearing) : 2.0 * exact::kPi - std::fabs(bearing);
    return {0.0, 0.0, direction * turn_rate_before(left)};
  };
  if (allowed_fraction(turned(turning_)) < params_.turn_blocked &&
      allowed_fraction(turned(-turning_)) >= params_.turn_blocked) {
    turning_ = -turning_;
    ++turned_back_;
  }
  return safe(turned(turning_));
}

Velocity PathFollower::turn(double angle) const {
  const double rate = std::max(params_.least_turn_rate, turn_rate_before(std::fabs(angle)));
  return safe({0.0, 0.0, angle >= 0.0 ? rate : -rate});
}

Velocity PathFollower::straight(double distance, double offset, double heading) {
  const double speed = std::max(creep_.speed, speed_before(std::fabs(distance)));
  const double forward = distance >= 0.0 ? speed : -speed;
  const double most_turn = creep_.free_turn_rate;
  if (kinematics_ == Kinematics::holonomic) {
    const double aside = std::clamp(params_.position_gain * offset, -creep_.free_speed, creep_.free_speed);
    return safe({forward, aside, std::clamp(params_.heading_gain * heading, -most_turn, most_turn)});
  }
  const double towards_line = (forward >= 0.0 ? offset : -offset) / params_.line_convergence;
  const double slow = std::min(1.0, speed / creep_.free_speed);
  const double omega = params_.heading_gain * (heading + towards_line * slow);
  return safe({forward, 0.0, std::clamp(omega, -most_turn, most_turn)});
}

double PathFollower::escape_speed() const { return params_.escape_speed * limits_.linear; }

Velocity PathFollower::most_room() const {
  const double speed = escape_speed();
  std::vector<Velocity> tries = {{-speed, 0.0, 0.0}, {speed, 0.0, 0.0}};
  if (kinematics_ == Kinematics::holonomic) {
    const double diagonal = speed * exact::sqrt(0.5);
    tries = {{-speed, 0.0, 0.0},          {0.0, speed, 0.0}, {0.0, -speed, 0.0},        {-diagonal, diagonal, 0.0},
             {-diagonal, -diagonal, 0.0}, {speed, 0.0, 0.0}, {diagonal, diagonal, 0.0}, {diagonal, -diagonal, 0.0}};
  } else {
    tries.push_back({-0.5 * speed, 0.0, 0.5 * limits_.angular});
    tries.push_back({-0.5 * speed, 0.0, -0.5 * limits_.angular});
  }
  Velocity best;
  double most = 0.0;
  for (const Velocity& v : tries) {
    if (const Sweep s = sweep(v, params_.horizon); s.seconds > most + 1e-9) most = s.seconds, best = v;
  }
  return safe(best);
}

Velocity PathFollower::safe(const Velocity& wanted) const { return scaled(wanted, allowed_fraction(wanted)); }

// Slower along the same curve, until the robot can stop before contact.
double PathFollower::allowed_fraction(const Velocity& v, double inside) const {
  const Sweep s = sweep(v, params_.horizon, inside);
  if (s.free) return 1.0;

  // at a fraction f contact comes after seconds / f; stopping takes reaction + f * braking
  const double speed = exact::hypot(v.vx, v.vy);
  const double braking = std::max(0.5 * speed / (params_.braking * limits_.linear_braking),
                                  0.5 * std::fabs(v.omega) / (params_.braking * limits_.angular_acceleration));
  // f * reaction + f^2 * braking = seconds
  const double reaction = params_.reaction;
  const double root = exact::sqrt(reaction * reaction + 4.0 * braking * s.seconds);
  const double f = braking > 1e-9 ? (root - reaction) / (2.0 * braking) : 1.0;
  return f < params_.least_speed ? 0.0 : std::min(f, 1.0);
}

// Point by point. A point comes nearer to the outline by no more than it moves in the base frame, so that those far
// from it are looked at seldom.
Sweep PathFollower::sweep(const Velocity& v, double horizon, double inside) const {
  const double speed = exact::hypot(v.vx, v.vy);
  const double rate = std::max(speed / params_.step, std::fabs(v.omega) / kTurnStep);
  if (rate <= 0.0 || near_.empty()) return {horizon, true};
  const double dt = 1.0 / rate;
  const Pose2D step = integrate({}, v, dt);
  const int steps = static_cast<int>(horizon / dt);
  const double most = margin_ + spare_ - inside;
  constexpr double kRounding = 1e-6;  // [m] more than what rounding does to where a point is
  const double way = norm(step.position());
  const double nearer = way + std::fabs(step.theta) * (reach_ + steps * way) + kRounding;  // at most, each step
  const double steps_per_metre = 1.0 / nearer;

  Motion motion(step);
  int contact = steps;
  for (std::size_t i = 0; i < near_.size(); ++i) {
    const double least = std::min(least_[i], most);
    for (int n = 0; n < contact;) {
      const double spare = outline_.clearance(motion.in_base(near_[i], n)) - least;
      if (spare < 0.0) {
        contact = n;
      } else {
        n += 1 + static_cast<int>(std::min(spare * steps_per_metre, 1.0 * steps));
      }
    }
  }
  return contact < steps ? Sweep{contact * dt, false} : Sweep{horizon, true};
}

// The speed from which the robot comes to rest within `distance`, reacting late and braking gently.
double PathFollower::speed_before(double distance) const {
  const double braking = params_.gentle_braking * limits_.linear_braking;
  return std::min(speed_to_stop(distance, braking, params_.reaction), limits_.linear);
}

double PathFollower::turn_rate_before(double angle) const {
  const double braking = params_.gentle_turn_braking * limits_.angular_acceleration;
  return std::min(speed_to_stop(angle, braking, params_.reaction), limits_.angular);
}

}  // namespace threewe::nav
