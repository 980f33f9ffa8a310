#include "threewe/nav/tracker.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "nav/polyline.hpp"

namespace threewe::nav {
namespace {

constexpr double kReaction = 0.12;      // [s] from a command to its effect
constexpr double kLargestSpare = 0.05;  // [m]
constexpr double kNotNearer = 0.005;    // [m] what is nearer than the margin may come so much nearer, no more
constexpr double kInside = 0.03;        // [m] of the margin that plans may use: scans are noisy, and the gate keeps it
constexpr double kHorizon = 1.2;        // [s] looked ahead along a motion
constexpr double kStep = 0.02;          // [m] or 0.1 rad between the poses that are tried
constexpr double kLookahead = 0.3;      // [m] along the path to where a differential base faces before it drives
constexpr double kTurnFirst = 0.8;      // [rad] differential: beyond this turn on the spot ...
constexpr double kTurnDone = 0.2;       // [rad] ... until the path is this straight ahead
constexpr double kEscape = 0.4;         // share of the speed limit when backing off

// Robots without a lidar hear what is ahead late and not always: they drive slowly.
RobotProfile driven_carefully(RobotProfile profile) {
  constexpr double kUnsighted = 0.25;  // [m/s]
  double& linear = profile.operating_limits.linear;
  if (!profile.lidar) linear = std::min(linear, kUnsighted);
  return profile;
}

// A quarter of the samples takes a quarter of the time. They reach as many goals in the scenes, but a differential base
// fails more often at doors 5 cm wider than itself.
MppiSettings settings() {
  MppiSettings s;
  s.samples = 512;
  s.weights.obstacle_speed = 10.0;
  return s;
}

Velocity scaled(const Velocity& v, double s) { return {s * v.vx, s * v.vy, s * v.omega}; }

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

Tracker::Tracker(const RobotProfile& profile)
    : mppi_(driven_carefully(profile), settings()),
      limits_(driven_carefully(profile).operating_limits),
      kinematics_(profile.kinematics()),
      outline_(profile.body.footprint),
      margin_(profile.margin()),
      inside_(profile.lidar ? kInside : 0.0),
      reach_(profile.body.footprint.circumscribed_radius() + margin_ + kLargestSpare +
             kHorizon * profile.operating_limits.linear) {}

void Tracker::look(const MppiObservation& seen) {
  odom_from_base_ = seen.odom_from_base;
  mppi_.see(seen);
}

void Tracker::see(std::span<const Vec2> obstacles_in_base, double spare) {
  spare_ = spare;
  near_.clear();
  least_.clear();
  for (const Vec2 p : obstacles_in_base) {
    if (dot(p, p) > reach_ * reach_) continue;
    near_.push_back(p);
    const double now = outline_.clearance(p);
    least_.push_back(std::min(margin_ + spare, now > 0.0 ? std::max(now - kNotNearer, 0.0) : now));
  }
}

Velocity Tracker::follow(std::span<const Vec2> path) {
  if (path.empty()) return {};
  if (kinematics_ == Kinematics::differential) {
    const PathPoint here = nearest_on_path(path, odom_from_base_.position());
    const Vec2 ahead = inverse(odom_from_base_) * point_after(path, here, kLookahead);
    const double bearing = exact::atan2(ahead.y, ahead.x);
    if (faces_first(bearing)) return face(bearing);
  }
  return mppi_.step({.path = path, .aside = aside_, .margin = margin_ + spare_ - inside_});
}

// A differential base turns on the spot towards what is not ahead, until it is.
bool Tracker::faces_first(double bearing) {
  if (turning_ == 0 && std::fabs(bearing) > kTurnFirst) turning_ = bearing > 0.0 ? 1 : -1;
  if (std::fabs(bearing) < kTurnDone) turning_ = 0;
  if (turning_ == 0) turned_back_ = 0;
  return turning_ != 0;
}

// The turn keeps its direction, even the long way round, and changes it only where something is in the way.
Velocity Tracker::face(double bearing) {
  constexpr double kBlocked = 0.2;  // a turn slower than this share of its speed leads nowhere
  const auto is_blocked = [&](int direction) {
    return allowed_fraction({0.0, 0.0, direction * limits_.angular}) < kBlocked;
  };
  if (is_blocked(turning_) && !is_blocked(-turning_)) {
    turning_ = -turning_;
    ++turned_back_;
  }
  const bool shorter = turning_ * bearing > 0.0;
  return turn(turning_ * (shorter ? std::fabs(bearing) : 2.0 * exact::kPi - std::fabs(bearing)));
}

Velocity Tracker::turn(double angle) { return mppi_.step({.turn = angle, .margin = margin_ + spare_ - inside_}); }

Velocity Tracker::straight(double distance, double offset, double heading) {
  const Vec2 along = rotate({1.0, 0.0}, heading);
  const Vec2 from = offset * Vec2{-along.y, along.x};
  const std::array<Vec2, 2> line = {odom_from_base_ * from, odom_from_base_ * (from + distance * along)};
  return mppi_.step(
      {.path = line, .backwards = distance < 0.0, .keep_line = true, .margin = margin_ + spare_ - inside_});
}

double Tracker::escape_speed() const { return kEscape * limits_.linear; }

Velocity Tracker::most_room() const {
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
    if (const Sweep s = sweep(v, kHorizon); s.seconds > most + 1e-9) most = s.seconds, best = v;
  }
  return safe(best);
}

Velocity Tracker::safe(const Velocity& wanted) const { return scaled(wanted, allowed_fraction(wanted)); }

// Slower along the same curve, until the robot can stop before contact.
double Tracker::allowed_fraction(const Velocity& v) const {
  const Sweep s = sweep(v, kHorizon);
  if (s.free) return 1.0;

  // at a fraction f contact comes after seconds / f; stopping takes reaction + f * braking
  const double speed = exact::hypot(v.vx, v.vy);
  const double braking = std::max(0.5 * speed / (0.6 * limits_.linear_braking),
                                  0.5 * std::fabs(v.omega) / (0.6 * limits_.angular_acceleration));
  // f * reaction + f^2 * braking = seconds
  const double root = exact::sqrt(kReaction * kReaction + 4.0 * braking * s.seconds);
  const double f = braking > 1e-9 ? (root - kReaction) / (2.0 * braking) : 1.0;
  return f < 0.03 ? 0.0 : std::min(f, 1.0);
}

Sweep Tracker::sweep(const Velocity& v, double horizon) const {
  const double speed = exact::hypot(v.vx, v.vy);
  const double pace = std::max(speed / kStep, std::fabs(v.omega) / 0.1);
  if (pace <= 0.0 || near_.empty()) return {horizon, true};
  const double dt = 1.0 / pace;
  const Pose2D step = integrate({}, v, dt);
  const int steps = static_cast<int>(horizon / dt);
  Pose2D pose;
  for (int n = 0; n < steps; ++n) {
    pose = pose * step;
    const auto [s, c] = exact::sincos(pose.theta);
    for (std::size_t i = 0; i < near_.size(); ++i) {
      const Vec2 d = near_[i] - pose.position();
      if (outline_.clearance({c * d.x + s * d.y, c * d.y - s * d.x}) < least_[i]) return {n * dt, false};
    }
  }
  return {horizon, true};
}

}  // namespace threewe::nav
