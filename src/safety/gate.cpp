#include "safety/gate.hpp"

#include <algorithm>
#include <array>

#include "hardware/limits.hpp"
#include "hardware/parameters.hpp"
#include "safety/collision_monitor.hpp"
#include "safety/creep_mode.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::safety {
namespace {

// A request that no robot could obey becomes a stop; a differential base has no vy.
Velocity sanitized(const GateModel& model, Velocity v) {
  if (!is_finite(v)) return {};
  if (model.kinematics == Kinematics::differential) v.vy = 0.0;
  return v;
}

// What the wheels can do together: a turn takes speed from a base whose wheels roll as fast as they can.
Velocity feasible(const GateModel& model, const Velocity& v) {
  return model.wheel_speed > 0.0 ? within_wheel_speed(model.wheels, model.wheel_speed, v) : v;
}

bool scan_is_stale(const GateModel& model, const GateState& state, Time now) {
  return model.collision_monitor && (!state.scan_seen || now - state.last_scan > model.sensor_timeout);
}

// What keeps clear of the surroundings.
Velocity monitored(const GateModel& model, const GateState& state, const Velocity& command,
                   const Surroundings& surroundings, const Pose2D& odom_from_base) {
  if (!state.crept) {
    const std::array all = {Obstacles{surroundings.hits, model.margin}, Obstacles{surroundings.assumed, model.margin}};
    return clear_of_obstacles(model, state, command, all, odom_from_base);
  }
  const Passage passage = measure_passage(model, command, surroundings, odom_from_base);
  const double lesser = std::min(model.margin, model.creep.margin);
  // a wall that is measured inside of the body shows that the lidar measures too near
  const std::array all = {Obstacles{passage.ahead, model.margin}, Obstacles{passage.beside, lesser, model.bias},
                          Obstacles{passage.assumed, lesser}};
  return clear_of_obstacles(model, state, command, all, odom_from_base);
}

GateOutput decide(const GateModel& model, GateState& state, const Request& request, const Surroundings& surroundings,
                  Time now, const Pose2D& odom_from_base) {
  if (state.estop) return {{}, Intervention::estop};

  const Velocity& requested = request.velocity;
  const bool stale = scan_is_stale(model, state, now);
  const bool creep_mode =
      request.creep_mode || (state.crept && is_in_passage(model, surroundings.hits, odom_from_base));
  state.crept = creep_mode && model.base_from_lidar && is_creeping(model, state);
  const Limits limits = creep_mode ? creep_limits(model) : model.limits;
  const Velocity allowed = stale ? Velocity{} : feasible(model, within_limits(limits, sanitized(model, requested)));
  const Velocity reachable = within_acceleration(model.limits, state.last(), allowed);
  if (stale && requested != Velocity{}) return {reachable, Intervention::stale_sensors};

  const bool watched = model.collision_monitor && !stale;
  const Velocity safe = watched ? monitored(model, state, reachable, surroundings, odom_from_base) : reachable;
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
  model.wheels = profile.body.wheels;
  model.wheel_speed = profile.hardware_limits.linear;
  model.footprint = profile.body.footprint;
  model.collision_monitor = profile.lidar || profile.ultrasonics;
  const auto params = params_for<Params>(profile, "safety");
  model.sensor_timeout = params.gate.sensor_timeout;
  model.margin = margin_of(profile);
  model.sweep_step = params.gate.sweep_step;
  model.creep = params.creep;
  if (profile.lidar) {
    model.base_from_lidar = profile.lidar->base_from_lidar.position();
    model.noise = profile.lidar->sigma;
    model.bias = profile.lidar->bias;
  }
  model.reaction = profile.reaction();
  if (model.reaction > kMaxReaction)
    throw ConfigError("profile '" + profile.name + "': reacts too slowly for the gate");
  return model;
}

GateOutput gate(const GateModel& model, GateState& state, const Request& request, const Surroundings& surroundings,
                Time now, const Pose2D& odom_from_base) {
  const GateOutput output = decide(model, state, request, surroundings, now, odom_from_base);
  state.recent.push(output.command);
  return output;
}

}  // namespace threewe::safety
