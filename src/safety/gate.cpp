#include "threewe/safety/gate.hpp"

#include <algorithm>

#include "collision_monitor.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::safety {
namespace {

constexpr double kPeriod = to_seconds(kControlPeriod);
// what rounding may add, so that a command the gate gave passes it again unchanged
constexpr double kRounding = 1.0 + 1e-12;

// A request that no robot could obey becomes a stop; a differential base has no vy.
Velocity sanitized(const GateModel& model, Velocity v) {
  if (!is_finite(v)) return {};
  if (model.kinematics == Kinematics::differential) v.vy = 0.0;
  return v;
}

// Scales the vector (vx, vy), so that it keeps its direction, and clamps the turn rate.
Velocity within_limits(const Limits& limits, Velocity v) {
  const double speed = exact::hypot(v.vx, v.vy);
  if (speed > limits.linear * kRounding) {
    v.vx *= limits.linear / speed;
    v.vy *= limits.linear / speed;
  }
  v.omega = std::clamp(v.omega, -limits.angular, limits.angular);
  return v;
}

// Moves from `last` straight towards `target`, as far as one period allows: as long as the line comes nearer to
// stand-still it brakes, beyond that it speeds up with what is left of the period.
Vec2 approach(Vec2 last, Vec2 target, double braking, double acceleration) {
  const Vec2 change = target - last;
  const double length = norm(change);
  if (length == 0.0) return target;

  const Vec2 direction = (1.0 / length) * change;
  const double slowing = std::clamp(-dot(last, direction), 0.0, length);  // length of the part that brakes
  const double braked = braking * kPeriod;
  if (slowing > braked) return last + braked * direction;

  const double reach = slowing + acceleration * kPeriod * (1.0 - slowing / braked);
  return length <= reach * kRounding ? target : last + reach * direction;
}

Velocity within_acceleration(const Limits& limits, const Velocity& last, const Velocity& target) {
  const Vec2 linear = approach({last.vx, last.vy}, {target.vx, target.vy}, limits.linear_braking,
                               limits.linear_acceleration);
  const Vec2 angular = approach({last.omega, 0.0}, {target.omega, 0.0}, limits.angular_acceleration,
                                limits.angular_acceleration);
  return {linear.x, linear.y, angular.x};
}

bool scan_is_stale(const GateModel& model, const GateState& state, Time now) {
  return model.collision_monitor && (!state.scan_seen || now - state.last_scan > model.sensor_timeout);
}

GateOutput decide(const GateModel& model, const GateState& state, const Velocity& requested,
                  std::span<const Vec2> obstacles, Time now) {
  if (state.estop) return {{}, Intervention::estop};

  const bool stale = scan_is_stale(model, state, now);
  const Velocity allowed = stale ? Velocity{} : within_limits(model.limits, sanitized(model, requested));
  const Velocity reachable = within_acceleration(model.limits, state.last(), allowed);
  if (stale && requested != Velocity{}) return {reachable, Intervention::stale_sensors};

  const Velocity safe =
      model.collision_monitor && !stale ? clear_of_obstacles(model, state, reachable, obstacles) : reachable;
  if (safe != reachable) {
    return {safe, safe == Velocity{} ? Intervention::stopped_for_obstacle : Intervention::slowed_for_obstacle};
  }
  return {safe, safe == requested ? Intervention::none : Intervention::limited};
}

}  // namespace

std::string_view to_string(Intervention intervention) {
  switch (intervention) {
    case Intervention::none: return "none";
    case Intervention::limited: return "limited";
    case Intervention::slowed_for_obstacle: return "slowed_for_obstacle";
    case Intervention::stopped_for_obstacle: return "stopped_for_obstacle";
    case Intervention::stale_sensors: return "stale_sensors";
    case Intervention::estop: return "estop";
  }
  return "unknown";
}

GateModel make_gate_model(const RobotProfile& profile) {
  GateModel model;
  model.limits = profile.operating_limits;
  model.kinematics = profile.kinematics();
  model.footprint = profile.body.footprint;
  model.collision_monitor = profile.lidar.has_value();
  // a unit that measures everything a little too far away must not touch either
  if (profile.lidar) model.margin += profile.lidar->bias;
  model.reaction = profile.command_latency + profile.body.motor_lag + kControlPeriod;
  if (model.reaction > kMaxReaction) throw ConfigError("profile '" + profile.name + "': reacts too slowly for the gate");
  return model;
}

GateOutput gate(const GateModel& model, GateState& state, const Velocity& requested, std::span<const Vec2> obstacles,
                Time now) {
  const GateOutput output = decide(model, state, requested, obstacles, now);
  std::copy_backward(state.recent.begin(), state.recent.end() - 1, state.recent.end());
  state.recent.front() = output.command;
  return output;
}

}  // namespace threewe::safety
