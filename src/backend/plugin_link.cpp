#include <algorithm>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "backend/plugin.hpp"
#include "backend/plugin_checks.hpp"
#include "hardware/sample_checks.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::backend {

namespace {
using Call = PluginRequest::Call;

constexpr Duration kShortestPatience = 100ms;  // for a step in real time, however soon its command expires
constexpr Time kNever = Time::min();
}  // namespace

std::string_view to_string(Call call) {
  switch (call) {
    case Call::connect: return "connect";
    case Call::disconnect: return "disconnect";
    case Call::step: return "step";
    case Call::reset: return "reset";
    case Call::save: return "save";
    case Call::restore: return "restore";
    case Call::truth: return "truth";
  }
  return "";
}

PluginLink::PluginLink(std::string name, Features features, RobotProfile profile, Duration patience)
    : name_(std::move(name)), features_(std::move(features)), profile_(std::move(profile)), patience_(patience) {
  check_features(name_, features_, profile_);
  begin_anew();
}

PluginTruth PluginLink::truth() {
  Lock lock(mutex_);
  if (!truth_ || !features_.lockstep) {
    const PluginTruth truth = ask(lock, {.call = Call::truth}).truth;
    truth_ = truth;
  }
  return *truth_;
}

void PluginLink::close() {
  const Lock lock(mutex_);
  quit_ = true;
  changed_.notify_all();
}

// The plug-in's thread: take, then answer or fail.

std::optional<PluginRequest> PluginLink::take() {
  Lock lock(mutex_);
  while (!(current_ = next_request())) {
    if (quit_) return std::nullopt;
    if (!features_.lockstep && plugin_connected_) {
      changed_.wait_until(lock, origin_ + next_step_);
    } else {
      changed_.wait(lock);
    }
  }

  // in real time a robot that may be moving must not be left alone beyond the end of its command
  const bool moving = velocity_at(now()) != Velocity{};
  give_up_ = moving ? std::max(command_.valid_until, now() + kShortestPatience) : now() + patience(current_->call);
  if (current_->call == Call::disconnect) plugin_connected_ = false;
  return current_;
}

/// First what makes the robot safe, then what the world asks for, then the next period of real time.
std::optional<PluginRequest> PluginLink::next_request() {
  if ((quit_ || fault_) && plugin_connected_) return PluginRequest{.call = Call::disconnect};
  if (quit_) return std::nullopt;
  if (posted_) return std::exchange(posted_, std::nullopt);
  if (features_.lockstep || !plugin_connected_ || now() < next_step_) return std::nullopt;
  next_step_ = std::max(next_step_ + kControlPeriod, now());
  return PluginRequest{.call = Call::step, .t = now(), .velocity = velocity_at(now())};
}

void PluginLink::answer(PluginReply reply) { finish(std::nullopt, std::move(reply)); }

void PluginLink::fail(const std::string& what) {
  finish(Fault{false, fmt::format("backend '{}': {}() raised {}", name_, to_string(current_->call), what)}, {});
}

void PluginLink::refuse(const std::string& what) {
  finish(Fault{true, fmt::format("backend '{}': {}", name_, what)}, {});
}

Time PluginLink::robot_time() const {
  const Lock lock(mutex_);
  return now();
}

void PluginLink::push(PluginReading reading) {
  const Lock lock(mutex_);
  if (fault_ || !plugin_connected_) return;
  std::vector<PluginReading> readings;
  readings.push_back(std::move(reading));
  fault_ = deliver(std::move(readings));
  if (fault_) changed_.notify_all();
}

void PluginLink::note_link_fault(std::string words) {
  const Lock lock(mutex_);
  link_fault_ = std::move(words);
}

void PluginLink::finish(std::optional<Fault> fault, PluginReply reply) {
  const Lock lock(mutex_);
  if (current_->call == Call::connect && !fault) plugin_connected_ = true;
  if (!fault_) {  // else the world has given up on this call
    if (!fault) fault = deliver(std::move(reply.readings));
    if (!fault && current_->call == Call::truth) fault = find_fault(reply.truth);
    if (current_->call == Call::reset && !fault) begin_anew();  // here, before a next step is due in real time
    fault_ = std::move(fault);
    // no call has requested a step in real time, and must not take the place of an answer that is still to be fetched
    if (features_.lockstep || current_->call != Call::step) reply_ = std::move(reply);
  }
  current_.reset();
  changed_.notify_all();
}

/// Lets readings arrive, all or none of them.
std::optional<PluginLink::Fault> PluginLink::deliver(std::vector<PluginReading> readings) {
  const Time latest = features_.lockstep ? current_->t : now();
  std::vector<Sample> samples;
  std::vector<Time> newest = newest_;
  try {
    for (PluginReading& reading : readings) {
      const std::size_t sensor = find_sensor(features_, reading.sensor);
      check_data(features_.sensors[sensor], reading.data, profile_);
      check_stamp(reading, newest[sensor], latest);
      newest[sensor] = reading.measured;
      samples.push_back({.sensor = static_cast<std::uint16_t>(sensor),
                         .sequence = 0,
                         .measured = reading.measured,
                         .received = {},
                         .data = std::move(reading.data)});
    }
  } catch (const ContractError& error) {
    return Fault{true, fmt::format("backend '{}': {}", name_, error.what())};
  }
  newest_ = std::move(newest);
  std::move(samples.begin(), samples.end(), std::back_inserter(arrived_));
  return std::nullopt;
}

std::optional<PluginLink::Fault> PluginLink::find_fault(const PluginTruth& truth) const {
  try {
    check_truth(truth);
  } catch (const ContractError& error) {
    return Fault{true, fmt::format("backend '{}': {}", name_, error.what())};
  }
  return std::nullopt;
}

// The world's thread, always with the lock held.

/// Hands over a request and waits for the reply. False when the plug-in is at fault.
bool PluginLink::exchange(Lock& lock, PluginRequest request) {
  const Call call = request.call;
  if (call != Call::truth) truth_.reset();
  if (!wait_until_idle(lock)) return false;
  reply_.reset();
  posted_ = std::move(request);
  changed_.notify_all();
  const bool finished = changed_.wait_for(lock, patience(call), [this] { return reply_ || fault_; });
  posted_.reset();
  if (!finished) {
    fault_ = Fault{false, fmt::format("backend '{}': {}() has not returned within {} s", name_, to_string(call),
                                      to_seconds(patience(call)))};
  }
  return !fault_;
}

PluginReply PluginLink::ask(Lock& lock, PluginRequest request) {
  throw_if_faulty();
  if (!exchange(lock, std::move(request))) throw_if_faulty();
  return std::move(*reply_);
}

/// Waits for the end of what the plug-in does on its own: a step in real time, disconnecting after a fault.
bool PluginLink::wait_until_idle(Lock& lock) {
  const auto idle = [this] { return !current_ && !(fault_ && plugin_connected_); };
  if (changed_.wait_for(lock, patience_, idle)) return true;
  const Call call = current_ ? current_->call : Call::disconnect;
  fault_ = Fault{false, fmt::format("backend '{}': {}() has not returned", name_, to_string(call))};
  return false;
}

void PluginLink::notice_hanging() {
  if (features_.lockstep || fault_ || !current_ || now() <= give_up_) return;
  fault_ = Fault{
      false, fmt::format("backend '{}': {}() blocks beyond the end of its command", name_, to_string(current_->call))};
}

void PluginLink::throw_if_faulty() const {
  if (!fault_) return;
  if (fault_->contract) throw ContractError(fault_->what);
  throw ConnectionError(fault_->what);
}

void PluginLink::begin_anew() {
  lockstep_now_ = {};
  origin_ = Clock::now();
  next_step_ = {};
  command_ = {};
  arrived_.clear();
  sequence_.assign(features_.sensors.size(), 0);
  newest_.assign(features_.sensors.size(), kNever);
}

Time PluginLink::now() const {
  return features_.lockstep ? lockstep_now_ : std::chrono::duration_cast<Time>(Clock::now() - origin_);
}

Velocity PluginLink::velocity_at(Time t) const { return t < command_.valid_until ? command_.velocity : Velocity{}; }

Duration PluginLink::patience(Call call) const {
  return call == Call::connect && !features_.lockstep ? 15 * patience_ : patience_;
}

}  // namespace threewe::backend
