#include "env/agent.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "core/exact.hpp"
#include "hardware/limits.hpp"
#include "models/lidar.hpp"
#include "models/localization_error.hpp"
#include "safety/collision_monitor.hpp"
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

  // as the collision monitor computes it
  const double stopping_time = gate.limits.linear / gate.limits.linear_braking;
  return past * age + gate.limits.linear * (to_seconds(gate.reaction + 2 * kControlPeriod) + 0.5 * stopping_time);
}

// Points of a turn, and the beams that they are sorted into.
struct Ranges {
  std::array<float, sim::kMaxLidarPoints> points;
  std::array<float, sim::kMaxLidarPoints> beams;
  Ranges() {}  // NOLINT: what is used is filled
};

// The beams of a scan that a lidar took in a turn, up to `reach` [m].
std::span<const float> retaken(const AgentModel& model, const sim::RobotModel& robot, const sim::RobotState& state,
                               const Turn& turn, double reach, Ranges& ranges) {
  const auto points = std::span(ranges.points).first(static_cast<std::size_t>(model.profile.lidar->points_per_turn));
  sim::retake_scan(robot, state, turn.number, turn.path, reach, points);
  if (model.beams.empty()) return points;
  const auto beams = std::span(ranges.beams).first(static_cast<std::size_t>(model.profile.lidar->beams));
  models::fill_scan(model.beams, points, beams);
  return beams;
}

// The same of one that may have been taken already.
std::span<const float> ranges_of(const AgentModel& model, const sim::RobotModel& robot, const sim::RobotState& state,
                                 const Scan& scan, double reach, Ranges& ranges) {
  return scan.ranges.empty() ? retaken(model, robot, state, scan, reach, ranges) : scan.ranges;
}

// [m] from wherever odometry had the base during a turn to where it places a hit, at least. `open` is known before.
double nearest_hit(const AgentModel& model, const sim::RobotModel& robot, const sim::RobotState& state,
                   const Turn& turn, OpenDisc& open) {
  constexpr double kFarthest = 2.0;  // [m] to look for what is near: then nothing is for the next few seconds
  constexpr double kMoved = 0.02;    // [m] after which it is worth while to look again: a tenth of taking a scan
  const Vec2 middle = turn.path[turn.path.size() / 2].position();
  double moved = distance(middle, open.center);
  if (open.radius - moved <= model.decision_sight + kMoved && (moved > kMoved || open.radius == 0.0)) {
    open = {middle, robot.caster->clearance(middle, kFarthest)};
    moved = 0.0;
  }
  double spread = 0.0;
  for (const Pose2D& pose : turn.path) spread = std::max(spread, distance(pose.position(), middle));
  const LidarSpec& lidar = *model.profile.lidar;
  const double error = models::most_too_short(lidar, state.lidar_bias, state.variation);
  const double turned = wrap_angle(turn.odom_at_end.theta - turn.odom_at_begin.theta);
  const double off_chord = 0.125 * turned * turned * norm(lidar.base_from_lidar.position());
  return open.radius - moved - spread - error - off_chord - model.displacement;
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
    // a scan that is remembered is asked from afar: from where the robot has got to since, twice as fast as it can
    const Duration remembered = model.sight_model.memory + 2 * lidar.turn;
    model.gate_sight = std::max(model.sight, model.sight_model.reach) + 2.0 * norm(lidar.base_from_lidar.position()) +
                       2.0 * model.profile.hardware_limits.linear * to_seconds(remembered);
    safety::GateState fastest;
    for (std::size_t i = 0; i < safety::RecentCommands::kSize; ++i) {
      fastest.recent.push({model.gate.limits.linear, 0.0, model.gate.limits.angular});
    }
    model.decision_sight = safety::sight_of_decision(model.gate, fastest);
    model.looks_late = model.gate.collision_monitor && options.robots == 1 && options.randomization.interval.empty();
    constexpr double kOfCaster = 1e-3;  // [m], more than its ranges are off
    model.displacement = 2.0 * exact::kPi / lidar.beams * norm(lidar.base_from_lidar.position()) + kOfCaster;
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
  const bool corrects = model.localizes && model.localization == Localization::noisy;
  correction_due_ = corrects ? model.localization_model.period : Time::max();
  if (model.scans) scans_.resize(model.scans_under_way);
  taken_ = arrived_ = 0;
  turn_began_ = {};
  obstacles_.clear();
  placed_ = true;
  kept_ = 0;
  path_.clear();
  open_ = {};
  if (model.looks_late && !others_move) {
    path_.resize(static_cast<std::size_t>(model.profile.lidar->turn / sim::kStep) + 1);
    // those before the newest that are not too old to tell what is free
    const auto turns = static_cast<std::size_t>(model.sight_model.memory / model.profile.lidar->turn);
    remembered_.resize(std::max<std::size_t>(turns, 1));
  }
}

Velocity Agent::act(const AgentModel& model, const sim::RobotModel& robot, const sim::RobotState& state,
                    const Velocity& action, Time now) {
  Velocity wanted = scaled_to(model.gate.limits, action);
  if (model.gate.kinematics == Kinematics::differential) wanted.vy = 0.0;
  if (!model.gate.collision_monitor) return safety::gate(model.gate, gate_, {wanted}, {}, now).command;

  const Pose2D base = odom_from_base(model, state);
  if (const Scan* scan = newest(); scan != nullptr && !placed_) {
    const Vec2 from = base.position();
    const double gone =
        std::max(distance(from, scan->odom_at_begin.position()), distance(from, scan->odom_at_end.position()));
    const double clear = nearest_ - gone;
    if (clear <= model.decision_sight && clear <= safety::sight_of_decision(model.gate, gate_)) {
      Ranges ranges;
      const double too_short = models::most_too_short(*model.profile.lidar, state.lidar_bias, state.variation);
      place_hits(model, *scan, ranges_of(model, robot, state, *scan, model.sight + too_short, ranges));
    }
  }
  std::span<const Vec2> assumed = sight_.unseen();
  std::vector<Vec2> with_predicted;  // only where there are any
  if (!approach_.approaching().empty()) {
    with_predicted.assign(assumed.begin(), assumed.end());
    approach_.append_predicted(model.approach, gate_.last(), base.position(), now, with_predicted);
    assumed = with_predicted;
  }
  return safety::gate(model.gate, gate_, {wanted}, {obstacles_, assumed}, now, base).command;
}

void Agent::end_turn(const AgentModel& model, const sim::RobotModel& robot, const sim::RobotState& state, ScanUse use) {
  const Pose2D began = std::exchange(turn_began_, odom_from_base(model, state));
  if (use == ScanUse::none) return;
  Scan& scan = scans_[taken_++ % scans_.size()];
  scan.end = state.time();
  scan.number = (state.steps - 1) / static_cast<std::uint64_t>(robot.turn);
  scan.arrives = scan.end + sim::varied_latency(model.profile.lidar->latency, state.variation);
  scan.odom_at_begin = began;
  scan.odom_at_end = turn_began_;
  scan.path.assign(path_.begin(), path_.end());
  scan.ranges.clear();
  if (use == ScanUse::gate && !path_.empty()) return;
  const auto points = sim::scan_points(robot, state);
  if (model.beams.empty()) return scan.ranges.assign(points.begin(), points.end());
  scan.ranges.resize(static_cast<std::size_t>(model.profile.lidar->beams));
  models::fill_scan(model.beams, points, scan.ranges);
}

void Agent::perceive(const AgentModel& model, const sim::RobotModel& robot, const sim::RobotState& state, Time now) {
  if (now >= correction_due_) correct(model, state, now);
  while (arrived_ < taken_ && scans_[arrived_ % scans_.size()].arrives <= now) {
    ++arrived_;
    gate_.last_scan = now;
    gate_.scan_seen = true;
    if (model.gate.collision_monitor) receive(model, robot, state);
  }
}

// Corrections come at multiples of their period; where such a moment is no end of a control period, none comes.
void Agent::correct(const AgentModel& model, const sim::RobotState& state, Time now) {
  const Duration period = model.localization_model.period;
  const auto number = now / period;
  correction_due_ = (number + 1) * period;
  if (now % period != Time::zero()) return;
  models::correct_localization(model.localization_model, state.key(Stream::localization),
                               static_cast<std::uint64_t>(number), inverse(state.start) * state.pose,
                               odom_from_base(model, state), localization_);
}

// What the gate makes of the newest scan. Where no beams in a row can be invalid, it only needs what is near, if any.
void Agent::receive(const AgentModel& model, const sim::RobotModel& robot, const sim::RobotState& state) {
  const Scan& scan = scans_[(arrived_ - 1) % scans_.size()];
  if (scan.path.empty()) {
    place_hits(model, scan, scan.ranges);
    return look_around(model, scan, scan.ranges);
  }

  nearest_ = nearest_hit(model, robot, state, scan, open_);
  if (is_without_gap(model, state, scan)) {
    obstacles_.clear();
    placed_ = false;
    remembered_[kept_++ % remembered_.size()] = scan;
    return;
  }
  Ranges ranges;
  for (std::size_t i = kept_ - std::min(kept_, remembered_.size()); i < kept_; ++i) {
    const Turn& past = remembered_[i % remembered_.size()];
    look_around(model, past, retaken(model, robot, state, past, model.gate_sight, ranges));
  }
  kept_ = 0;
  const auto beams = ranges_of(model, robot, state, scan, model.gate_sight, ranges);
  place_hits(model, scan, beams);
  look_around(model, scan, beams);
}

// Whether it is known that no three beams of a turn, side by side, are invalid, nor was anything unseen before.
bool Agent::is_without_gap(const AgentModel& model, const sim::RobotState& state, const Turn& turn) const {
  const LidarSpec& lidar = *model.profile.lidar;
  if (nearest_ - norm(lidar.base_from_lidar.position()) <= lidar.range_min) return false;
  if (!sight_.unseen().empty()) return false;
  const auto points = static_cast<std::uint64_t>(lidar.points_per_turn);
  return !models::drops_neighbours(lidar, state.key(Stream::lidar), turn.number * points, state.variation);
}

// What the newest scan hits is an obstacle.
void Agent::place_hits(const AgentModel& model, const Turn& turn, std::span<const float> ranges) {
  const LidarSpec& lidar = *model.profile.lidar;
  const Pose2D begin = turn.odom_at_begin * lidar.base_from_lidar;
  const Pose2D end = turn.odom_at_end * lidar.base_from_lidar;
  obstacles_.clear();
  safety::append_scan_points(lidar, ranges, begin, end, obstacles_, model.sight);
  placed_ = true;
}

// What a scan does not see counts as an obstacle, too, and what comes nearer where it will be.
void Agent::look_around(const AgentModel& model, const Turn& turn, std::span<const float> ranges) {
  const LidarSpec& lidar = *model.profile.lidar;
  const Pose2D begin = turn.odom_at_begin * lidar.base_from_lidar;
  const Pose2D end = turn.odom_at_end * lidar.base_from_lidar;
  const Pose2D& began = lidar.rolling ? begin : end;
  const Pose2D& first = lidar.clockwise ? end : began;
  const Pose2D& last = lidar.clockwise ? began : end;
  sight_.add(model.sight_model, {turn.end, first, last}, ranges, turn.odom_at_end);
  if (others_move_) approach_.update(model.approach, sight_, gate_.last());
}

std::vector<Vec2> Agent::hits(const AgentModel& model, const sim::RobotState& state) const {
  std::vector<Vec2> points;
  if (!newest()) return points;
  const LidarSpec& lidar = *model.profile.lidar;
  const Pose2D base_from_odom = inverse(odom_from_base(model, state));
  const auto placed = [&](const Pose2D& odom_from_base) {
    return base_from_odom * odom_from_base * lidar.base_from_lidar;
  };
  safety::append_scan_points(lidar, scan(), placed(newest()->odom_at_begin), placed(newest()->odom_at_end), points);
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

}  // namespace threewe::env
