#include "env/agent.hpp"

#include <algorithm>
#include <utility>

#include "hardware/limits.hpp"
#include "models/lidar.hpp"
#include "models/localization_error.hpp"
#include "safety/scan_points.hpp"
#include "sim/step.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::env {
namespace {

// How many times its latency a scan takes at most.
int most_latency(const Options& options) {
  return draws(options.randomization, "sensor_latency") ? models::kMostLatency : 1;
}

// [m] that the robot can go from when a point is measured until it stands, if the next scan shows no such point.
double farthest_way(const Options& options, const safety::GateModel& gate, const LidarSpec& lidar) {
  // how fast it may have moved already: pushed, perhaps, and by wheels that slip
  const double past = 2.0 * gate.limits.linear;
  const double age = to_seconds(2 * lidar.turn + most_latency(options) * lidar.latency + kControlPeriod);

  // as the collision monitor reckons
  const double stopping_time = gate.limits.linear / gate.limits.linear_braking;
  return past * age + gate.limits.linear * (to_seconds(gate.reaction + 2 * kControlPeriod) + 0.5 * stopping_time);
}

}  // namespace

AgentModel make_agent_model(const Options& options, const Clock& clock, bool localizes) {
  AgentModel model;
  model.profile = options.hardware;
  model.gate = safety::make_gate_model(options.data_sheet.value_or(model.profile));
  model.localization = options.localization;
  model.localization_model = options.localization_model;
  model.scans = clock.scans;
  model.localizes = localizes;
  if (options.gate == Gate::limits) model.gate.collision_monitor = false;
  if (model.gate.collision_monitor && !model.profile.lidar) {
    throw ConfigError(
        "gate: '" + model.profile.name +
        "' detects obstacles by sonar and has no lidar; batches detect them with lidars alone: use 'limits'");
  }
  if (model.profile.lidar) {
    const LidarSpec& lidar = *model.profile.lidar;
    model.sight_model = safety::make_sight_model(options.data_sheet.value_or(model.profile), model.gate);
    model.approach = safety::make_approach_model(options.data_sheet.value_or(model.profile), model.gate);
    model.scans_under_way = static_cast<std::size_t>(most_latency(options) * lidar.latency / lidar.turn) + 2;
    model.sight = farthest_way(options, model.gate, lidar) + norm(lidar.base_from_lidar.position()) +
                  model.gate.margin + model.gate.footprint.circumscribed_radius();
    model.beams = models::beams_of_points(lidar);
    const bool in_order = std::ranges::all_of(model.beams, [i = 0U](const models::PointBeams& beams) mutable {
      const unsigned point = i++;
      return beams.first == point && beams.second == point;
    });
    if (in_order) model.beams.clear();
  }
  return model;
}

void Agent::begin(const AgentModel& model, bool others_move) {
  gate_ = {};
  sight_.forget();
  approach_.forget();
  others_move_ = others_move;
  localization_ = {};
  if (model.scans) scans_.resize(model.scans_under_way);
  taken_ = arrived_ = 0;
  turn_began_ = {};
  obstacles_.clear();
}

Velocity Agent::act(const AgentModel& model, const sim::RobotState& state, const Velocity& action, Time now) {
  Velocity wanted = scaled_to(model.gate.limits, action);
  if (model.gate.kinematics == Kinematics::differential) wanted.vy = 0.0;
  const Pose2D base = odom_from_base(model, state);
  std::span<const Vec2> assumed = sight_.unseen();
  std::vector<Vec2> with_predicted;  // only where there are any
  if (!approach_.approaching().empty()) {
    with_predicted.assign(assumed.begin(), assumed.end());
    approach_.append_predicted(model.approach, gate_.last(), base.position(), now, with_predicted);
    assumed = with_predicted;
  }
  return safety::gate(model.gate, gate_, {wanted}, {obstacles_, assumed}, now, base).command;
}

void Agent::end_turn(const AgentModel& model, const sim::RobotModel& robot, const sim::RobotState& state, bool whole) {
  const Pose2D began = std::exchange(turn_began_, odom_from_base(model, state));
  if (!whole) return;
  Scan& scan = scans_[taken_++ % scans_.size()];
  scan.end = state.time();
  scan.arrives = scan.end + sim::varied_latency(model.profile.lidar->latency, state.variation);
  scan.odom_at_begin = began;
  scan.odom_at_end = turn_began_;
  const auto points = sim::scan_points(robot, state);
  scan.points.assign(points.begin(), points.end());
}

void Agent::perceive(const AgentModel& model, const sim::RobotState& state, Time now) {
  const Duration period = model.localization_model.period;
  if (model.localizes && model.localization == Localization::noisy && now % period == Time::zero()) {
    models::correct_localization(model.localization_model, state.key(Stream::localization),
                                 static_cast<std::uint64_t>(now / period), inverse(state.start) * state.pose,
                                 odom_from_base(model, state), localization_);
  }
  while (arrived_ < taken_ && scans_[arrived_ % scans_.size()].arrives <= now) {
    ++arrived_;
    gate_.last_scan = now;
    gate_.scan_seen = true;
    if (!model.gate.collision_monitor) continue;
    const LidarSpec& lidar = *model.profile.lidar;
    std::array<float, sim::kMaxLidarPoints> beams;  // NOLINT: what is used is filled
    const auto ranges = scan(model, std::span(beams).first(static_cast<std::size_t>(lidar.beams)));
    obstacles_.clear();
    safety::append_scan_points(lidar, ranges, newest()->odom_at_begin, newest()->odom_at_end, obstacles_, model.sight);
    look_around(model, ranges);
  }
}

// What the newest scan does not see counts as an obstacle, and what comes nearer where it will be.
void Agent::look_around(const AgentModel& model, std::span<const float> ranges) {
  const LidarSpec& lidar = *model.profile.lidar;
  const Scan& scan = *newest();
  const Pose2D& began = lidar.rolling ? scan.odom_at_begin : scan.odom_at_end;
  const Pose2D& first = lidar.clockwise ? scan.odom_at_end : began;
  const Pose2D& last = lidar.clockwise ? began : scan.odom_at_end;
  sight_.add(model.sight_model, {scan.end, first * lidar.base_from_lidar, last * lidar.base_from_lidar}, ranges,
             scan.odom_at_end);
  if (others_move_) approach_.update(model.approach, sight_, gate_.last());
}

std::vector<Vec2> Agent::hits(const AgentModel& model, const sim::RobotState& state) const {
  std::vector<Vec2> points;
  if (!newest()) return points;
  const LidarSpec& lidar = *model.profile.lidar;
  std::vector<float> beams(static_cast<std::size_t>(lidar.beams));
  const Pose2D base_from_odom = inverse(odom_from_base(model, state));
  safety::append_scan_points(lidar, scan(model, beams), base_from_odom * newest()->odom_at_begin,
                             base_from_odom * newest()->odom_at_end, points);
  return points;
}

Pose2D Agent::odom_from_base(const AgentModel& model, const sim::RobotState& state) const {
  if (model.localization == Localization::truth) return inverse(state.start) * state.pose;
  return state.odometry.reading.pose;
}

Pose2D Agent::map_from_base(const AgentModel& model, const sim::RobotState& state) const {
  const Pose2D odom = odom_from_base(model, state);
  return model.localization == Localization::noisy ? models::localized_pose(localization_, odom) : odom;
}

Velocity Agent::velocity(const AgentModel& model, const sim::RobotState& state) const {
  return model.localization == Localization::truth ? state.velocity : state.odometry.reading.velocity;
}

std::span<const float> Agent::scan(const AgentModel& model, std::span<float> beams) const {
  if (!newest()) return {};
  if (model.beams.empty()) return newest()->points;
  models::fill_scan(model.beams, newest()->points, beams);
  return beams;
}

}  // namespace threewe::env
