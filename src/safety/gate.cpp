#include "safety/gate.hpp"

#include <algorithm>

#include "hardware/limits.hpp"
#include "safety/collision_monitor.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::safety {
namespace {

// A request that no robot could obey becomes a stop; a differential base has no vy.
Velocity sanitized(const GateModel& model, Velocity v) {
  if (!is_finite(v)) return {};
  if (model.kinematics == Kinematics::differential) v.vy = 0.0;
  return v;
}

bool scan_is_stale(const GateModel& model, const GateState& state, Time now) {
  return model.collision_monitor && (!state.scan_seen || now - state.last_scan > model.sensor_timeout);
}

GateOutput decide(const GateModel& model, const GateState& state, const Velocity& requested,
                  std::span<const Vec2> obstacles, Time now, const Pose2D& base) {
  if (state.estop) return {{}, Intervention::estop};

  const bool stale = scan_is_stale(model, state, now);
  const Velocity allowed = stale ? Velocity{} : within_limits(model.limits, sanitized(model, requested));
  const Velocity reachable = within_acceleration(model.limits, state.last(), allowed);
  if (stale && requested != Velocity{}) return {reachable, Intervention::stale_sensors};

  const Velocity safe =
      model.collision_monitor && !stale ? clear_of_obstacles(model, state, reachable, obstacles, base) : reachable;
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
  model.collision_monitor = profile.lidar || profile.ultrasonics;
  model.margin = profile.margin();
  model.reaction = profile.reaction();
  if (model.reaction > kMaxReaction)
    throw ConfigError("profile '" + profile.name + "': reacts too slowly for the gate");
  return model;
}

GateModel creep_mode(const GateModel& model) {
  constexpr double kMargin = 0.003;  // [m]
  constexpr double kLinear = 0.04;   // [m/s]
  constexpr double kCorners = 0.05;  // [m/s]
  GateModel slow = model;
  slow.margin = std::min(slow.margin, kMargin);
  slow.limits.linear = std::min(slow.limits.linear, kLinear);
  slow.limits.angular = std::min(slow.limits.angular, (kCorners - kLinear) / model.footprint.circumscribed_radius());
  return slow;
}

GateOutput gate(const GateModel& model, GateState& state, const Velocity& requested, std::span<const Vec2> obstacles,
                Time now, const Pose2D& base) {
  const GateOutput output = decide(model, state, requested, obstacles, now, base);
  std::copy_backward(state.recent.begin(), state.recent.end() - 1, state.recent.end());
  state.recent.front() = output.command;
  return output;
}

}  // namespace threewe::safety
