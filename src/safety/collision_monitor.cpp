#include "safety/collision_monitor.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "safety/limits.hpp"

namespace threewe::safety {
namespace {

constexpr double kPeriod = to_seconds(kControlPeriod);
constexpr double kSweepStep = 0.005;  // [m], the longest way of any corner between two poses of a sweep
constexpr double kRounding = 1e-9;    // [m]
constexpr double kStandStill = 1e-3;  // [m/s] and [rad/s], slower than this is not worth creeping
constexpr int kBisections = 10;       // the speed is found to a thousandth

Velocity scaled(double s, const Velocity& v) { return {s * v.vx, s * v.vy, s * v.omega}; }

Velocity blend(const Velocity& a, const Velocity& b, double t) {
  return {a.vx + t * (b.vx - a.vx), a.vy + t * (b.vy - a.vy), a.omega + t * (b.omega - a.omega)};
}

// [s] to stand-still when all components shrink together, so that braking keeps to the arc.
double stopping_time(const Limits& limits, const Velocity& v) {
  return std::max(exact::hypot(v.vx, v.vy) / limits.linear_braking, std::abs(v.omega) / limits.angular_acceleration);
}

// One period of braking along the arc.
Velocity braked(const Limits& limits, const Velocity& v) {
  if (v == Velocity{}) return v;
  const double time = stopping_time(limits, v);
  return time <= kPeriod ? Velocity{} : scaled(1.0 - kPeriod / time, v);
}

// Follows the footprint over the floor. At every pose it calls `visit(obstacle, clearance [m])` for the obstacles that
// are within the margin, until one answers false.
class Sweep {
 public:
  Sweep(const GateModel& model, std::span<const Vec2> obstacles, const Pose2D& pose = {})
      : model_(model), obstacles_(obstacles), pose_(pose) {}

  template <typename Visit>
  bool drive(const Velocity& v, const Visit& visit) {
    if (v == Velocity{}) return true;
    const double way = (exact::hypot(v.vx, v.vy) + std::abs(v.omega) * radius()) * kPeriod;
    const int steps = std::max(1, static_cast<int>(std::ceil(way / kSweepStep)));
    for (int i = 0; i < steps; ++i) {
      pose_ = integrate(pose_, v, kPeriod / steps);
      if (!look(visit)) return false;
    }
    return true;
  }

  template <typename Visit>
  bool brake(Velocity v, const Visit& visit) {
    for (v = braked(model_.limits, v); v != Velocity{}; v = braked(model_.limits, v)) {
      if (!drive(v, visit)) return false;
    }
    return true;
  }

  template <typename Visit>
  bool look(const Visit& visit) const {
    const double sight = radius() + model_.margin;
    const auto [s, c] = exact::sincos(pose_.theta);
    for (std::size_t i = 0; i < obstacles_.size(); ++i) {
      const Vec2 d = obstacles_[i] - pose_.position();
      if (dot(d, d) > sight * sight) continue;
      const Vec2 in_base{c * d.x + s * d.y, c * d.y - s * d.x};
      if (!model_.footprint.may_be_near(in_base, model_.margin)) continue;
      if (!visit(i, model_.footprint.signed_distance(in_base))) return false;
    }
    return true;
  }

  const Pose2D& pose() const { return pose_; }

 private:
  double radius() const { return model_.footprint.circumscribed_radius(); }
  const GateModel& model_;
  std::span<const Vec2> obstacles_;
  Pose2D pose_;  // in the present base frame
};

// [m] that the base can travel before it stands still, whatever is decided now.
double reach(const GateModel& model, const GateState& state, std::size_t pending, const Velocity& command) {
  double way = 0.0;
  for (std::size_t i = 0; i < pending; ++i) way += exact::hypot(state.recent[i].vx, state.recent[i].vy) * kPeriod;
  for (const Velocity& v : {command, state.last()}) {
    const double speed = exact::hypot(v.vx, v.vy);
    way += speed * (kPeriod + 0.5 * stopping_time(model.limits, v));
  }
  return way;
}

std::vector<Vec2> within(std::span<const Vec2> points, double radius) {
  std::vector<Vec2> near;
  for (const Vec2 p : points) {
    if (dot(p, p) <= radius * radius) near.push_back(p);
  }
  return near;
}

// The clearance that each obstacle must keep: the margin, but never more than braking at once would leave. What lies
// inside the outline already may come no deeper, and never licenses touching something else.
std::vector<double> required_clearance(double margin, const std::vector<double>& when_braking) {
  const double least = *std::min_element(when_braking.begin(), when_braking.end());
  const double common = std::clamp(least, 0.0, margin);
  std::vector<double> required;
  for (const double d : when_braking) required.push_back(std::min(d, common) - kRounding);
  return required;
}

}  // namespace

Velocity clear_of_obstacles(const GateModel& model, const GateState& state, const Velocity& command,
                            std::span<const Vec2> obstacles) {
  const auto pending = static_cast<std::size_t>((model.reaction + kControlPeriod - 1ns) / kControlPeriod);
  const double sight = model.footprint.circumscribed_radius() + model.margin + reach(model, state, pending, command);
  const std::vector<Vec2> near = within(obstacles, sight);
  if (near.empty()) return command;

  // the robot will first obey what it was told before
  std::vector<double> nearest(near.size(), std::numeric_limits<double>::infinity());
  const auto keep_nearest = [&](std::size_t i, double clearance) {
    nearest[i] = std::min(nearest[i], clearance);
    return true;
  };
  Sweep sweep(model, near);
  sweep.look(keep_nearest);
  for (std::size_t i = pending; i-- > 0;) sweep.drive(state.recent[i], keep_nearest);
  const Pose2D turning_point = sweep.pose();

  // braking at once is always allowed, and the measure of what else is
  const Velocity fallback = braked(model.limits, state.last());
  sweep.brake(state.last(), keep_nearest);
  const std::vector<double> required = required_clearance(model.margin, nearest);
  const auto is_enough = [&](std::size_t i, double clearance) { return clearance >= required[i]; };
  const auto keeps_clear = [&](const Velocity& v) {
    Sweep trial(model, near, turning_point);
    return trial.drive(v, is_enough) && trial.brake(v, is_enough);
  };
  if (keeps_clear(command)) return command;

  // the largest step from braking towards the command that keeps clear
  const auto between = [&](double t) {
    return within_acceleration(model.limits, state.last(), blend(fallback, command, t));
  };
  double safe = 0.0;
  double unsafe = 1.0;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = 0.5 * (safe + unsafe);
    (keeps_clear(between(middle)) ? safe : unsafe) = middle;
  }
  const Velocity slowed = between(safe);
  const bool creeping = exact::hypot(slowed.vx, slowed.vy) < kStandStill && std::abs(slowed.omega) < kStandStill;
  return creeping && fallback == Velocity{} ? Velocity{} : slowed;
}

}  // namespace threewe::safety
