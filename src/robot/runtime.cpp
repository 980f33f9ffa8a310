#include "threewe/robot/runtime.hpp"

#include <cmath>
#include <exception>
#include <utility>

#include "hardware/limits.hpp"
#include "robot/goals.hpp"
#include "robot/runtime_state.hpp"
#include "safety/gate.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/robot/warning.hpp"

namespace threewe {
namespace {

constexpr Duration kPatienceAtStart = 2s;  // for the first sample of every sensor

void require_positive(Duration duration, const char* what) {
  if (duration <= Duration::zero()) throw ContractError(std::string(what) + " must be positive");
}

}  // namespace

Runtime::Impl::Impl(World& w, backend::RobotPort& p, Options autonomy)
    : world(w),
      port(p),
      perception_model(perception::make_perception_model(p.profile(), p.features().sensors)),
      gate_model(safety::make_gate_model(p.profile())),
      sight_model(safety::make_sight_model(p.profile(), gate_model)),
      approach_model(safety::make_approach_model(p.profile(), gate_model)),
      fresh(std::move(autonomy), perception_model),
      state(std::make_unique<State>(fresh)) {
  note_health();
}

Runtime::Runtime(World& world, backend::RobotPort& port, Options autonomy)
    : impl_(std::make_unique<Impl>(world, port, std::move(autonomy))) {}

Runtime::~Runtime() { impl_->end_motion(Reason::cancelled, "the robot is gone"); }

void Runtime::connect() {
  if (impl_->healthy()) return;
  impl_->port.connect();
  impl_->connected = true;
  impl_->fault.clear();

  // what was seen before is old by now, but an emergency stop stays latched
  State& state = *impl_->state;
  state.senses = impl_->fresh.senses;
  state.perception.begin(impl_->perception_model, impl_->shared().current());  // connecting may take seconds
  state.gate = {.estop = state.gate.estop};
  state.sight.forget();
  state.approach.forget();
  state.poses.clear();
  state.estimate = state.localizer->estimate(impl_->now());
  impl_->note_health();
}

void Runtime::disconnect() {
  if (!impl_->connected) return;
  impl_->state->held.reset();
  impl_->end_motion(Reason::cancelled, "disconnected");
  impl_->end_ready();
  (void)impl_->halt();
  impl_->connected = false;
  impl_->port.disconnect();
}

bool Runtime::connected() const { return impl_->connected; }
const std::string& Runtime::fault() const { return impl_->fault; }
const RobotProfile& Runtime::profile() const { return impl_->port.profile(); }
const World& Runtime::world() const { return impl_->world; }
const backend::Features& Runtime::features() const { return impl_->port.features(); }

WaitHandle Runtime::ready() {
  impl_->require_healthy();
  if (impl_->state->senses.complete()) return impl_->world.sleep(Duration::zero());
  const Duration connecting = impl_->shared().current() - impl_->now();  // seconds, on a real robot
  return impl_->ready.emplace_back(impl_->world.sleep(connecting + kPatienceAtStart));
}

void Runtime::set_velocity(const Velocity& velocity, Duration hold, bool creep_mode) {
  impl_->require_healthy();
  check_velocity(profile(), velocity);
  require_positive(hold, "hold");
  impl_->require_free();
  impl_->state->held = HeldVelocity{velocity, impl_->now() + hold, false, creep_mode};
}

WaitHandle Runtime::execute_action(const std::array<double, 3>& action, Duration period, bool creep_mode) {
  impl_->require_healthy();
  for (const double a : action) {
    if (!std::isfinite(a)) throw ContractError("action must be finite");
  }
  const Velocity velocity = scaled_to(profile().operating_limits, {action[0], action[1], action[2]});
  check_velocity(profile(), velocity);
  require_positive(period, "period");
  impl_->require_free();
  impl_->state->held = HeldVelocity{velocity, impl_->now() + period, true, creep_mode};
  return impl_->world.sleep(period);
}

void Runtime::stop() {
  impl_->state->held.reset();
  impl_->end_motion(Reason::cancelled, "stopped");
}

MotionHandle Runtime::start(const nav::Goal& goal, std::optional<Duration> timeout) {
  impl_->require_healthy();
  check_goal(goal);
  if (timeout) require_positive(*timeout, "timeout");
  if (std::holds_alternative<nav::Explore>(goal) && !features().has(SensorType::lidar)) {
    throw HardwareError("robot '" + profile().name + "' has no sensor 'lidar', which exploring needs");
  }
  impl_->require_free();

  State& state = *impl_->state;
  impl_->listen_to_peers();
  state.navigator->start(goal, impl_->observation());
  MotionHandle handle = impl_->begin(goal, {}, timeout);
  handle->runtime_ = this;
  handle->progress_ = state.navigator->progress();
  return handle;
}

MotionHandle Runtime::drive(VelocitySource source, std::optional<Duration> timeout) {
  impl_->require_healthy();
  if (timeout) require_positive(*timeout, "timeout");
  impl_->require_free();
  MotionHandle handle = impl_->begin({}, std::move(source), timeout);
  handle->runtime_ = this;
  handle->progress_.pose = impl_->state->estimate.map_from_base();
  return handle;
}

MotionHandle Runtime::Impl::begin(std::optional<nav::Goal> goal, VelocitySource source,
                                  std::optional<Duration> timeout) {
  state->held.reset();
  auto handle = std::make_shared<Motion>();
  const auto times_out = timeout ? std::optional(now() + *timeout) : std::nullopt;
  motion = OpenMotion{.handle = handle,
                      .goal = std::move(goal),
                      .source = std::move(source),
                      .began = now(),
                      .times_out = times_out,
                      .decision = {},
                      .given_up = {},
                      .decided = {}};
  shared().waits.add(handle, WaitList::Kind::motion, times_out.value_or(Time::max()));
  return handle;
}

nav::MoveTo Runtime::in_map(const nav::MoveTo& goal, std::string_view frame) const {
  check_goal(goal);  // as it was given: a transform spreads what is not finite
  const Pose2D map_from_frame = transform("map", frame);
  nav::MoveTo there = goal;
  there.goal = map_from_frame * goal.goal;
  if (goal.theta) there.theta = wrap_angle(map_from_frame.theta + *goal.theta);
  return there;
}

MotionHandle Runtime::motion() const { return impl_->motion ? impl_->motion->handle : nullptr; }

void Runtime::set_zones(const std::vector<map::Zone>& zones) {
  for (const map::Zone& zone : zones) check_zone(zone);
  impl_->state->navigator->set_zones(zones);
  impl_->state->zones = zones;
}

const std::vector<map::Zone>& Runtime::zones() const { return impl_->state->zones; }

void Runtime::estop() {
  State& state = *impl_->state;
  state.gate.estop = true;
  state.held.reset();
  impl_->end_motion(Reason::estop, "the emergency stop was pressed");
  if (!impl_->healthy()) return;
  // at once, not at the next tick: in real time that may be a period away
  if (const auto error = impl_->halt()) fail(*error);
}

void Runtime::release_estop() { impl_->state->gate.estop = false; }
bool Runtime::estopped() const { return impl_->state->gate.estop; }

void Runtime::fail(const std::string& what) {
  if (!impl_->healthy()) return;
  impl_->fault = what.empty() ? "unknown fault" : what;
  impl_->state->held.reset();
  impl_->end_motion(Reason::fault, impl_->fault);
  impl_->end_ready();
  (void)impl_->halt();
  warn("robot '" + profile().name + "' failed and stands still: " + impl_->fault);
}

std::uint64_t Runtime::observe(Observer observer) {
  const std::uint64_t id = ++impl_->observers_made;
  impl_->observers.emplace_back(id, std::make_shared<const Observer>(std::move(observer)));
  return id;
}

void Runtime::unobserve(std::uint64_t id) {
  std::erase_if(impl_->observers, [id](const auto& entry) { return entry.first == id; });
}

std::shared_ptr<const Runtime::State> Runtime::save() const {
  if (impl_->motion) throw ContractError("a motion is in progress: save before it or after it");
  return std::make_shared<const State>(*impl_->state);
}

void Runtime::restore(const State& state) {
  impl_->end_motion(Reason::cancelled, "the world was restored");
  impl_->end_ready();
  impl_->state = std::make_unique<State>(state);
  impl_->fault.clear();
}

void Runtime::restart() {
  impl_->end_motion(Reason::cancelled, "the world was reset");
  impl_->end_ready();
  impl_->state = std::make_unique<State>(impl_->fresh);
  impl_->fault.clear();
}

// Commands zero, or tells what went wrong. A port that cannot be reached stops the robot by itself when its last
// command expires.
std::optional<std::string> Runtime::Impl::halt() {
  try {
    port.command({}, now() + kCommandLifetime);
    return std::nullopt;
  } catch (const std::exception& error) {
    return error.what();
  }
}

void Runtime::Impl::require_healthy() const {
  if (!connected) throw ConnectionError("robot '" + port.profile().name + "' is not connected; call connect() first");
  if (!fault.empty())
    throw ConnectionError("robot '" + port.profile().name + "' failed: " + fault + "; call connect()");
}

void Runtime::Impl::require_free() const {
  if (state->gate.estop) throw EmergencyStopError("the emergency stop is latched; call release_emergency_stop() first");
  if (motion) throw SafetyError("a motion owns the robot; call stop() or cancel it first");
}

void Motion::cancel() {
  if (runtime_ != nullptr) runtime_->impl_->end_motion(Reason::cancelled, "");
}

const MoveResult& Motion::result() const {
  if (!done()) throw ContractError("the motion is still in progress");
  return result_;
}

ExploreResult Motion::explore_result() const {
  const MoveResult& r = result();
  return {r.success, r.reason, r.detail, explored_area_, r.distance, r.duration};
}

}  // namespace threewe
