// The two halves of a tick: act and sense.
#include <algorithm>
#include <exception>

#include <fmt/format.h>

#include "core/exact.hpp"
#include "hardware/sample_checks.hpp"
#include "hardware/turn.hpp"
#include "robot/delegated_localizer.hpp"
#include "robot/delegated_navigator.hpp"
#include "robot/goals.hpp"
#include "robot/runtime_state.hpp"
#include "robot/zone_limits.hpp"
#include "safety/gate.hpp"
#include "threewe/robot/warning.hpp"

namespace threewe {
namespace {

double free_area(const map::OccupancyGrid& grid) {
  const auto free = std::count_if(grid.data.begin(), grid.data.end(), [](std::int8_t value) {
    return value != map::OccupancyGrid::kUnknown && value <= map::OccupancyGrid::kFreeThreshold;
  });
  return static_cast<double>(free) * grid.resolution * grid.resolution;
}

std::string in_seconds(Duration d) { return fmt::format("{:.2f} s", to_seconds(d)); }
std::string in_metres(double metres) { return fmt::format("{:.2f} m", metres); }

// A sensor's fault in words.
std::string in_words(const SensorHealth& sensor, const char* verb) {
  std::string text = "sensor '" + sensor.name + "' " + verb + " " + std::string(to_string(sensor.fault));
  return sensor.detail.empty() ? text : text + " (" + sensor.detail + ")";
}

}  // namespace

void Runtime::act(Time now) {
  if (!impl_->healthy()) return;
  try {
    State& state = *impl_->state;
    state.requested = impl_->request();
    state.commanded = impl_->gated(now);
    impl_->port.command(state.commanded.command, now + kCommandLifetime);
  } catch (const std::exception& error) {
    fail(error.what());
  }
}

void Runtime::sense(Time now) {
  if (!impl_->healthy()) return;
  std::vector<Sample> samples;
  try {
    samples = impl_->perceive();
  } catch (const std::exception& error) {
    return fail(error.what());
  }
  tell({now, samples, impl_->state->estimate, impl_->state->requested, impl_->state->commanded, *this});
  impl_->end_motion_if_over();
}

// What is in the way, and what may be: where no beam has looked, and where what comes nearer is going.
safety::GateOutput Runtime::Impl::gated(Time now) {
  const bool creep_mode = motion ? motion->decision.creep_mode : state->held && state->held->creep_mode;
  const Pose2D& base = state->estimate.odom_from_base;
  const std::span<const Vec2> unseen = state->sight.unseen();
  std::vector<Vec2> assumed(unseen.begin(), unseen.end());
  state->approach.append_predicted(approach_model, state->gate.last(), base.position(), now, assumed);
  return safety::gate(gate_model, state->gate, {state->requested, creep_mode}, {obstacles_in_odom(), assumed}, now,
                      base);
}

// A motion owns the robot; without one, a velocity that was asked for holds until it expires.
Velocity Runtime::Impl::request() {
  const SensorHealth* sensor = state->perception.health().blocking_sensor();
  // another program that drives the robot has sensors to look at
  const bool ours = !motion || !state->navigator->drives_past_the_gate();
  if (sensor != nullptr && (ours || out_of_reach())) return wait_for(*sensor);
  return motion ? steer() : held_velocity();
}

// Stands still until a sensor is sound again, or for so long that there is no hope. Where not one sensor delivers the
// robot is out of reach: it must not start by itself when it is back.
Velocity Runtime::Impl::wait_for(const SensorHealth& sensor) {
  (void)held_velocity();  // which may expire meanwhile
  if (out_of_reach() && std::exchange(state->held, std::nullopt)) {
    warn("robot '" + port.profile().name + "' is out of reach: it stands still until it is commanded anew");
  }
  state->waited += kControlPeriod;
  if (!motion || motion->decided) return {};
  motion->decision = {};
  if (out_of_reach()) {
    motion->given_up = "no sensor has delivered for " + in_seconds(kLinkPatience) + ": the robot is out of reach";
  } else if (now() - sensor.since >= kSensorPatience) {
    motion->given_up = in_words(sensor, "has been") + " for " + in_seconds(kSensorPatience);
  }
  return {};
}

// By what was fetched last: where this process itself was kept waiting since, what came meanwhile has not been seen.
bool Runtime::Impl::out_of_reach() const { return state->sensed - state->last_arrival >= kLinkPatience; }

Velocity Runtime::Impl::steer() {
  if (motion->decided) return {};  // it has ended but for coming to a stop
  if (motion->source) {
    motion->decision = steer_by_source();
    return motion->decision.velocity;
  }
  if (waits_for_its_place()) return {};
  listen_to_peers();
  motion->decision = state->navigator->step(observation());
  motion->handle->progress_ = state->navigator->progress();
  return motion->decision.reason == Reason::running ? motion->decision.velocity : Velocity{};
}

// Within zones, as the navigator keeps to them; no velocity where the motion is over.
nav::Decision Runtime::Impl::steer_by_source() {
  Progress& progress = motion->handle->progress_;
  progress.pose = state->estimate.map_from_base();
  progress.distance_driven = motion->distance;
  if (state->estimate.lost()) return {.velocity = {}, .reason = Reason::lost};
  try {
    nav::Decision decision = motion->source(now());
    if (decision.reason != Reason::running) decision.velocity = {};
    check_velocity(port.profile(), decision.velocity);
    decision.velocity = within_zones(port.profile(), state->zones, progress.pose, decision.velocity);
    return decision;
  } catch (const std::exception& error) {
    return {.velocity = {}, .reason = Reason::policy_error, .detail = error.what()};
  }
}

// Where another program says where the robot is, and has fallen silent, looking around does not help: a motion in the
// map waits as it does for a sensor.
bool Runtime::Impl::waits_for_its_place() {
  const auto program = program_health(*state->localizer, now());
  const bool relative =
      std::holds_alternative<nav::Rotate>(*motion->goal) || std::holds_alternative<nav::MoveForward>(*motion->goal);
  if (!program || program->ok() || relative || state->navigator->drives_past_the_gate()) {
    motion->without_place = {};
    return false;
  }
  state->waited += kControlPeriod;
  motion->without_place += kControlPeriod;
  motion->decision = {};
  if (motion->without_place >= kSensorPatience) {
    motion->decision.reason = Reason::lost;
    motion->decision.detail = fmt::format("{}: {}", program->name, program->detail);
  }
  return true;
}

Velocity Runtime::Impl::held_velocity() {
  if (!state->held) return {};
  const HeldVelocity held = *state->held;
  if (now() < held.until) return held.velocity;

  state->held.reset();
  if (held.velocity != Velocity{} && !held.quiet && !warned_of_expiry) {
    warned_of_expiry = true;
    warn("a velocity held longer than its `hold` allows: the robot stops; call set_velocity again in time to go on");
  }
  return {};
}

// What the other robots tell, where all have one `map` frame: what they know themselves, never the truth.
void Runtime::Impl::listen_to_peers() {
  peers.clear();
  if (!shared().one_map_frame) return;
  for (std::size_t i = 0; i < shared().robots.size(); ++i) {
    const Impl& other = *shared().robots[i]->impl_;
    if (&other == this || !other.healthy() || !other.port.profile().lidar) continue;
    const std::span<const Vec2> path = shared().robots[i]->path();
    peers.push_back({.name = "robot " + std::to_string(i),
                     .map_from_base = other.state->estimate.map_from_base(),
                     .velocity = other.state->estimate.velocity,
                     .radius = other.port.profile().body.footprint.circumscribed_radius(),
                     .bound_for = path.empty() ? std::nullopt : std::optional(path.back()),
                     .map = &other.state->localizer->map()});
  }
}

nav::Observation Runtime::Impl::observation() const {
  const Time time = now() - state->waited;
  const slam::Localizer& localizer = *state->localizer;
  if (port.profile().lidar) {
    return {.now = time,
            .pose = state->estimate,
            .map = localizer.map(),
            .map_version = localizer.map_version(),
            .obstacles = obstacles_in_odom(),
            .map_changes = localizer.map_changes(),
            .peers = peers,
            .people = state->perception.people(),
            .commanded = state->gate.last()};
  }
  return {.now = time,
          .pose = state->estimate,
          .map = state->perception.sonar_grid().grid(),
          .map_version = state->perception.sonar_grid().version(),
          .obstacles = obstacles_in_odom(),
          .commanded = state->gate.last()};
}

std::vector<Sample> Runtime::Impl::perceive() {
  std::vector<Sample> samples = port.poll();
  std::vector<const Sample*> usable;
  state->sensed = now();
  if (!samples.empty()) state->last_arrival = now();
  for (const Sample& sample : samples) {
    check_kind(port.features().sensors, sample);
    if (!state->perception.examine(perception_model, sample)) {
      if (moves_a_delegated_pose(sample)) state->localizer->add(sample);
      continue;
    }
    usable.push_back(&sample);
    state->senses.remember(sample);
    state->localizer->add(sample);
    if (const auto* battery = std::get_if<BatteryState>(&sample.data); battery && battery->charge <= 0.0 && motion)
      motion->given_up = "the battery is empty";
    if (looks_with(port.features().sensors[sample.sensor].type)) {
      state->gate.last_scan = sample.received;
      state->gate.scan_seen = true;
    }
  }
  const Vec2 before = state->estimate.odom_from_base.position();
  const bool driven_by_another = motion && state->navigator->drives_past_the_gate();  // at what we do not know
  state->estimate = state->localizer->estimate(now());
  state->perception.update(perception_model,
                           {.now = now(),
                            .samples = usable,
                            .pose = state->estimate,
                            .hits = state->localizer->obstacles(),
                            .commanded = driven_by_another ? state->estimate.velocity : state->commanded.command});
  note_health();
  warn_of_faults();
  state->poses.add(now(), state->estimate.odom_from_base);
  for (const Sample* sample : usable) look_around(*sample);
  if (motion) motion->distance += distance(before, state->estimate.odom_from_base.position());
  if (state->senses.complete()) end_ready();
  return samples;
}

// Odometry that comes late, or is not trusted since some did: a program that localises the robot corrects it, and while
// another drives, a pose that waits for better would stay behind.
bool Runtime::Impl::moves_a_delegated_pose(const Sample& sample) const {
  const SensorHealth& health = state->perception.health().sensors()[sample.sensor];
  return std::holds_alternative<Odometry>(sample.data) && health.fault != SensorFault::implausible &&
         known_until(*state->localizer);
}

// What stands around the robot is looked for with the lidar and only where there is none with ultrasonic sensors alone.
bool Runtime::Impl::looks_with(SensorType type) const {
  return type == (port.profile().lidar ? SensorType::lidar : SensorType::ultrasonic);
}

std::span<const Vec2> Runtime::Impl::obstacles_in_odom() const {
  return state->perception.obstacles(perception_model, state->localizer->obstacles());
}

// Where the lidar is blind, and what comes nearer.
void Runtime::Impl::look_around(const Sample& sample) {
  const auto* scan = std::get_if<LaserScan>(&sample.data);
  if (scan == nullptr || !port.profile().lidar) return;
  const LidarSpec& lidar = *port.profile().lidar;
  const Time end = end_of_turn(lidar, *scan, sample.measured);
  const Pose2D at_end = state->poses.at(end);
  const Pose2D at_begin = scan->time_increment != 0.0 ? state->poses.at(end - lidar.turn) : at_end;
  const bool clockwise = scan->time_increment < 0.0;
  Pose2D base_from_lidar = lidar.base_from_lidar;
  if (scan->angle_min != -exact::kPi)
    base_from_lidar = base_from_lidar * Pose2D{0.0, 0.0, wrap_angle(scan->angle_min + exact::kPi)};
  state->sight.add(
      sight_model,
      {end, (clockwise ? at_end : at_begin) * base_from_lidar, (clockwise ? at_begin : at_end) * base_from_lidar},
      scan->ranges, at_end);
  state->approach.update(approach_model, state->sight, state->gate.last());
}

void Runtime::tell(const TickView& view) {
  // a copy, since observers may come and go meanwhile
  const auto observers = impl_->observers;
  for (const auto& [id, observer] : observers) {
    const auto is_this = [id = id](const auto& entry) { return entry.first == id; };
    if (std::none_of(impl_->observers.begin(), impl_->observers.end(), is_this)) continue;
    try {
      (*observer)(view);
    } catch (...) {
      if (!impl_->shared().observer_error) impl_->shared().observer_error = std::current_exception();
    }
  }
}

// A motion that the navigator or a source ends is over when the robot stands; a time limit and a fault do not wait for
// that.
void Runtime::Impl::end_motion_if_over() {
  constexpr Duration kStops = 1s;    // a robot that has not stopped by then is pushed
  constexpr Duration kLocates = 2s;  // for a pose that is newer than what another program says of its arrival
  if (!motion) return;
  if (motion->times_out && now() >= *motion->times_out)
    return end_motion(Reason::timeout, "after " + in_seconds(now() - motion->began));
  if (!motion->given_up.empty()) return end_motion(Reason::fault, std::string(motion->given_up));
  if (motion->decision.reason == Reason::running) return;
  if (!motion->decided) motion->decided = now();
  const Duration since = now() - *motion->decided;
  if ((!stands() && since < kStops) || (!knows_where_it_ended() && since < kLocates)) return;
  const auto [reason, detail] = verdict();
  end_motion(reason, detail);
}

bool Runtime::Impl::stands() const {
  constexpr double kStill = 0.01;      // [m/s]
  constexpr double kStillTurn = 0.02;  // [rad/s]
  const Velocity& moving = state->estimate.velocity;
  return state->commanded.command == Velocity{} && exact::hypot(moving.vx, moving.vy) < kStill &&
         std::abs(moving.omega) < kStillTurn;
}

// A program that drives may say that it has arrived while readings of how it got there are still on their way, or were
// refused as they came late.
bool Runtime::Impl::knows_where_it_ended() const {
  if (motion->decision.reason != Reason::reached || !state->navigator->drives_past_the_gate()) return true;
  return known_until(*state->localizer).value_or(now()) >= *motion->decided;
}

// What the navigator says; but within the tolerance is only who is so wherever the true position may be.
std::pair<Reason, std::string> Runtime::Impl::verdict() const {
  const nav::Decision& decision = motion->decision;
  if (!motion->goal) return {decision.reason, decision.detail};
  const std::optional<double> tolerance = tolerance_in_map(*motion->goal);
  const double away = distance_to_goal(*motion->goal, state->estimate.map_from_base(), motion->handle->progress_);
  if (state->navigator->drives_past_the_gate()) {
    // who drives says when it has arrived, by tolerances of its own
    if (!knows_where_it_ended()) {
      return {Reason::uncertain, "who drives says that it has arrived; no new reading says where the robot is"};
    }
    if (decision.reason != Reason::reached || away <= *tolerance) return {decision.reason, decision.detail};
    return {Reason::uncertain, "who drives says that it has arrived; it stands " + in_metres(away) +
                                   " from its goal, more than the tolerance of " + in_metres(*tolerance)};
  }
  const double uncertainty = state->estimate.position_uncertainty();
  if (decision.reason != Reason::reached || !tolerance || away + uncertainty <= *tolerance)
    return {decision.reason, decision.detail};
  return {Reason::uncertain, "it stands " + in_metres(away) + " from its goal by an estimate that may be off by " +
                                 in_metres(uncertainty) + ", which the tolerance of " + in_metres(*tolerance) +
                                 " does not allow for"};
}

void Runtime::Impl::end_motion(Reason reason, const std::string& detail) {
  if (!motion) return;
  const OpenMotion ended = *std::exchange(motion, std::nullopt);
  state->navigator->end();
  const Pose2D pose = state->estimate.map_from_base();

  Motion& handle = *ended.handle;
  handle.runtime_ = nullptr;
  handle.explored_area_ = free_area(state->localizer->map());
  handle.result_ = {.success = reason == Reason::reached,
                    .reason = reason,
                    .detail = detail,
                    .pose = pose,
                    .position_uncertainty = state->estimate.position_uncertainty(),
                    .distance_to_goal = ended.goal ? distance_to_goal(*ended.goal, pose, handle.progress_) : 0.0,
                    .distance = ended.distance,
                    .duration = to_seconds(now() - ended.began)};
  shared().waits.end(ended.handle, now());
}

void Runtime::Impl::end_ready() {
  for (const WaitHandle& wait : std::exchange(ready, {})) shared().waits.end(wait, now());
}

void Runtime::Impl::note_health() {
  auto localizer = program_health(*state->localizer, now());
  auto navigator = program_health(*state->navigator);
  if (!localizer && !navigator) return;
  std::vector<SensorHealth> before = std::exchange(state->health, state->perception.health().sensors());
  const auto add = [&](std::optional<SensorHealth> program) {
    if (!program) return;
    const auto known = std::ranges::find(before, program->name, &SensorHealth::name);
    const bool changed = known != before.end() && known->ok() != program->ok();
    if (known == before.end() || changed) {
      program->since = now();
    } else {
      program->since = known->since;
    }
    if (changed) {
      warn("robot '" + port.profile().name + "': '" + program->name + "' " +
           (program->ok() ? "is ok again" : "is " + std::string(to_string(program->fault)) + ": " + program->detail));
    }
    state->health.push_back(*std::move(program));
  };
  add(std::move(localizer));
  add(std::move(navigator));
}

// Of each sensor whose fault begins or is over, and of the way to the robot.
void Runtime::Impl::warn_of_faults() {
  if (std::string fault_now = port.link_fault(); fault_now != warned_of_link) {
    warned_of_link = std::move(fault_now);
    if (!warned_of_link.empty()) warn("robot '" + port.profile().name + "': " + warned_of_link);
  }
  for (const std::size_t i : state->perception.take_health_changes()) {
    const SensorHealth& sensor = state->perception.health().sensors()[i];
    const std::string whose = "robot '" + port.profile().name + "': ";
    if (sensor.ok()) {
      warn(whose + "sensor '" + sensor.name + "' is ok again");
    } else {
      warn(whose + in_words(sensor, "is") +
           (sensor.needed ? "; it stands still until that is over" : "; it does without"));
    }
  }
}

}  // namespace threewe
