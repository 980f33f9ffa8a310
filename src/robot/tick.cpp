// The two halves of a tick: act and sense.
#include <algorithm>
#include <exception>

#include <fmt/format.h>

#include "core/exact.hpp"
#include "hardware/sample_checks.hpp"
#include "hardware/turn.hpp"
#include "robot/goals.hpp"
#include "robot/runtime_state.hpp"
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
  if (const SensorHealth* sensor = state->perception.health().blocking_sensor()) return wait_for(*sensor);
  return motion ? steer() : held_velocity();
}

// Stands still until a sensor is sound again, or for so long that there is no hope. Where not one sensor delivers the
// robot is out of reach: it must not start by itself when it is back.
Velocity Runtime::Impl::wait_for(const SensorHealth& sensor) {
  (void)held_velocity();  // which may expire meanwhile
  const bool out_of_reach = now() - state->last_arrival >= kLinkPatience;
  if (out_of_reach && std::exchange(state->held, std::nullopt)) {
    warn("robot '" + port.profile().name + "' is out of reach: it stands still until it is commanded anew");
  }
  state->waited += kControlPeriod;
  if (!motion || motion->stands_by) return {};
  motion->decision = {};
  if (out_of_reach) {
    motion->given_up = "no sensor has delivered for " + in_seconds(kLinkPatience) + ": the robot is out of reach";
  } else if (now() - sensor.since >= kSensorPatience) {
    motion->given_up = in_words(sensor, "has been") + " for " + in_seconds(kSensorPatience);
  }
  return {};
}

Velocity Runtime::Impl::steer() {
  if (motion->stands_by) return {};  // it has ended but for coming to a stop
  listen_to_peers();
  motion->decision = state->navigator->step(observation());
  motion->handle->progress_ = state->navigator->progress();
  return motion->decision.reason == Reason::running ? motion->decision.velocity : Velocity{};
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
    const std::span<const Vec2> path = other.motion ? other.state->navigator->path() : std::span<const Vec2>();
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
  if (!samples.empty()) state->last_arrival = now();
  for (const Sample& sample : samples) {
    check_kind(port.features().sensors, sample);
    if (!state->perception.examine(perception_model, sample)) continue;
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
  state->estimate = state->localizer->estimate(now());
  state->perception.update(perception_model, {.now = now(),
                                              .samples = usable,
                                              .pose = state->estimate,
                                              .hits = state->localizer->obstacles(),
                                              .commanded = state->commanded.command});
  warn_of_faults();
  state->poses.add(now(), state->estimate.odom_from_base);
  for (const Sample* sample : usable) look_around(*sample);
  if (motion) motion->distance += distance(before, state->estimate.odom_from_base.position());
  if (state->senses.complete()) end_ready();
  return samples;
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

// A motion that the navigator ends is over when the robot stands; a time limit and a fault do not wait for that.
void Runtime::Impl::end_motion_if_over() {
  constexpr Duration kStops = 1s;  // a robot that has not stopped by then is pushed
  if (!motion) return;
  if (motion->times_out && now() >= *motion->times_out)
    return end_motion(Reason::timeout, "after " + in_seconds(now() - motion->began));
  if (!motion->given_up.empty()) return end_motion(Reason::fault, std::string(motion->given_up));
  if (motion->decision.reason == Reason::running) return;
  if (!motion->stands_by) motion->stands_by = now() + kStops;
  if (!stands() && now() < *motion->stands_by) return;
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

// What the navigator says; but within the tolerance is only who is so wherever the true position may be.
std::pair<Reason, std::string> Runtime::Impl::verdict() const {
  const nav::Decision& decision = motion->decision;
  const std::optional<double> tolerance = tolerance_in_map(motion->goal);
  const double uncertainty = state->estimate.position_uncertainty();
  const double away = distance_to_goal(motion->goal, state->estimate.map_from_base(), motion->handle->progress_);
  if (decision.reason != Reason::reached || !tolerance || away + uncertainty <= *tolerance)
    return {decision.reason, decision.detail};
  return {Reason::uncertain, "it stands " + in_metres(away) + " from its goal by an estimate that may be off by " +
                                 in_metres(uncertainty) + ", which the tolerance of " + in_metres(*tolerance) +
                                 " does not allow for"};
}

void Runtime::Impl::end_motion(Reason reason, const std::string& detail) {
  if (!motion) return;
  const OpenMotion ended = *std::exchange(motion, std::nullopt);
  const Pose2D pose = state->estimate.map_from_base();

  Motion& handle = *ended.handle;
  handle.runtime_ = nullptr;
  handle.explored_area_ = free_area(state->localizer->map());
  handle.result_ = {.success = reason == Reason::reached,
                    .reason = reason,
                    .detail = detail,
                    .pose = pose,
                    .position_uncertainty = state->estimate.position_uncertainty(),
                    .distance_to_goal = distance_to_goal(ended.goal, pose, handle.progress_),
                    .distance = ended.distance,
                    .duration = to_seconds(now() - ended.began)};
  shared().waits.end(ended.handle, now());
}

void Runtime::Impl::end_ready() {
  for (const WaitHandle& wait : std::exchange(ready, {})) shared().waits.end(wait, now());
}

// Of each sensor whose fault begins or is over.
void Runtime::Impl::warn_of_faults() {
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
