#include <algorithm>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "backend/plugin.hpp"
#include "core/bytes.hpp"
#include "core/rng.hpp"
#include "hardware/limits.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::backend {

namespace {

using Call = PluginRequest::Call;

// Plug-ins know seeds alone: each of their episodes has one of its own.
std::uint64_t seed_of(const ResetOptions& options) {
  if (options.episode == 0) return options.seed;
  const auto bits = random_bits({.seed = options.seed, .episode = options.episode}, 0);
  return std::uint64_t{bits[0]} << 32U | bits[1];
}

}  // namespace

PluginWorld::PluginWorld(std::shared_ptr<PluginLink> link, std::unique_ptr<const scene::TruthView> truth)
    : link_(std::move(link)), truth_(std::move(truth)) {}

RobotPort& PluginWorld::robot(std::size_t index) {
  if (index != 0) throw ContractError(fmt::format("robot {} of a world with one robot", index));
  return *this;
}

Time PluginWorld::now() const {
  const PluginLink::Lock lock(link_->mutex_);
  return link_->now();
}

void PluginWorld::advance_to(Time t) {
  PluginLink::Lock lock(link_->mutex_);
  if (!link_->features_.lockstep) {
    const auto until = link_->origin_ + t;
    lock.unlock();
    std::this_thread::sleep_until(until);
    return;
  }
  while (link_->lockstep_now_ < t) {
    // a step ends with the period, or where the command expires
    const Time now = link_->lockstep_now_;
    Time end = std::min(t, now + kControlPeriod);
    if (const Time expiry = link_->command_.valid_until; expiry > now) end = std::min(end, expiry);

    // what goes wrong in it shows in the next poll, to the robot that it concerns
    if (link_->connected_ && !link_->fault_) {
      link_->exchange(lock, {.call = Call::step, .t = end, .velocity = link_->velocity_at(now)});
    }
    link_->lockstep_now_ = end;
  }
}

void PluginWorld::connect() {
  PluginLink::Lock lock(link_->mutex_);
  if (link_->connected_ && !link_->fault_) return;
  link_->connected_ = false;
  if (!link_->wait_until_idle(lock)) link_->throw_if_faulty();
  link_->fault_.reset();
  link_->link_fault_.clear();
  link_->arrived_.clear();
  link_->command_ = {};
  link_->next_step_ = link_->now();
  link_->ask(lock, {.call = Call::connect});
  link_->connected_ = true;
}

void PluginWorld::disconnect() {
  PluginLink::Lock lock(link_->mutex_);
  if (!link_->connected_) return;
  link_->connected_ = false;
  link_->command_ = {};
  if (!link_->fault_) link_->ask(lock, {.call = Call::disconnect});
}

std::vector<Sample> PluginWorld::poll() {
  const PluginLink::Lock lock(link_->mutex_);
  if (!link_->connected_) throw ConnectionError(fmt::format("backend '{}': poll() while not connected", link_->name_));
  link_->notice_hanging();
  link_->throw_if_faulty();
  std::vector<Sample> samples = std::exchange(link_->arrived_, {});
  for (Sample& sample : samples) {
    sample.sequence = link_->sequence_[sample.sensor]++;
    sample.received = link_->now();
  }
  return samples;
}

void PluginWorld::command(const Velocity& velocity, Time valid_until) {
  if (!is_finite(velocity)) throw ContractError("the velocity is not finite");
  if (velocity.vy != 0.0 && link_->profile_.kinematics() == Kinematics::differential) {
    throw ContractError(fmt::format("vy is {} m/s; a differential base cannot drive sideways", velocity.vy));
  }
  const PluginLink::Lock lock(link_->mutex_);
  if (!link_->connected_)
    throw ConnectionError(fmt::format("backend '{}': command() while not connected", link_->name_));
  link_->notice_hanging();
  link_->throw_if_faulty();
  link_->command_ = {within_limits(link_->profile_.hardware_limits, velocity), valid_until};
}

std::string PluginWorld::link_fault() const {
  const PluginLink::Lock lock(link_->mutex_);
  return link_->link_fault_;
}

void PluginWorld::reset(const ResetOptions& options) {
  if (!link_->features_.can_reset) World::reset(options);
  PluginLink::Lock lock(link_->mutex_);
  PluginRequest request{.call = Call::reset, .seed = seed_of(options)};
  if (!options.poses.empty()) request.pose = options.poses.front();
  link_->ask(lock, std::move(request));
}

std::vector<std::byte> PluginWorld::save() const {
  if (!link_->features_.can_save) return World::save();
  PluginLink::Lock lock(link_->mutex_);
  const PluginReply reply = link_->ask(lock, {.call = Call::save});
  ByteWriter bytes;
  bytes.put(link_->lockstep_now_);
  bytes.put(link_->command_);
  for (const std::uint64_t sequence : link_->sequence_) bytes.put(sequence);
  for (const Time stamp : link_->newest_) bytes.put(stamp);
  bytes.put(std::uint64_t{link_->arrived_.size()});
  for (const Sample& sample : link_->arrived_) bytes.put(sample);
  bytes.put(std::uint64_t{reply.state.size()});
  bytes.put_bytes(reply.state);
  return bytes.take();
}

void PluginWorld::restore(const std::vector<std::byte>& state) {
  if (!link_->features_.can_save) World::restore(state);
  PluginLink::Lock lock(link_->mutex_);
  Time now{};
  PluginLink::Command command;
  std::vector<std::uint64_t> sequence(link_->sequence_.size());
  std::vector<Time> newest(link_->newest_.size());
  PluginRequest request{.call = Call::restore};
  ByteReader bytes(state, kNotSaved);
  bytes.get(now);
  bytes.get(command);
  for (std::uint64_t& number : sequence) bytes.get(number);
  for (Time& stamp : newest) bytes.get(stamp);
  std::vector<Sample> arrived(bytes.get_size());
  for (Sample& sample : arrived) {
    bytes.get(sample);
    if (sample.sensor >= sequence.size())
      throw ContractError("restore: these bytes are no saved world of this backend");
  }
  request.state.resize(bytes.get_size());
  for (std::byte& byte : request.state) bytes.get(byte);
  bytes.finish();
  link_->ask(lock, std::move(request));

  // only now, so that a failure leaves nothing half restored
  link_->begin_anew();
  link_->lockstep_now_ = now;
  link_->command_ = command;
  link_->sequence_ = std::move(sequence);
  link_->newest_ = std::move(newest);
  link_->arrived_ = std::move(arrived);
}

}  // namespace threewe::backend
