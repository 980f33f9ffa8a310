// What the port of every simulator in lockstep does: it keeps the command in force and the samples on their way.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "backend/bytes.hpp"
#include "threewe/backend/world.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::backend {

/// What a profile's sensors are in a simulator that can do all that `Features` knows.
Features simulated_features(const RobotProfile& profile, bool with_camera);

/// `Recipe` is what a sample is made of once it has arrived, beyond its data.
template <typename Recipe>
class SimulatedPort : public RobotPort {
 public:
  /// All of a port that changes while it is connected.
  struct State {
    struct Arrival {
      Time time;
      Sample sample;
      Recipe recipe;
    };

    Velocity command;
    Time valid_until{};
    std::vector<Arrival> arrivals;         ///< by time
    std::vector<std::uint64_t> sequences;  ///< the next number of each sensor
  };

  SimulatedPort(const World& world, RobotProfile profile, Features features)
      : world_(world), profile_(std::move(profile)), features_(std::move(features)) {
    reset();
  }

  const Features& features() const override { return features_; }
  const RobotProfile& profile() const override { return profile_; }
  void connect() override { connected_ = true; }

  void disconnect() override {
    connected_ = false;
    state_.command = {};
    state_.arrivals.clear();
  }

  std::vector<Sample> poll() override {
    require_connection("poll");
    auto& arrivals = state_.arrivals;
    const auto arrived =
        std::ranges::find_if(arrivals, [&](const auto& arrival) { return arrival.time > world_.now(); });
    std::vector<Sample> samples;
    for (auto arrival = arrivals.begin(); arrival != arrived; ++arrival) {
      Sample& sample = samples.emplace_back(std::move(arrival->sample));
      finish(sample, arrival->recipe);
      sample.sequence = state_.sequences[sample.sensor]++;
      sample.received = world_.now();
    }
    arrivals.erase(arrivals.begin(), arrived);
    return samples;
  }

  void command(const Velocity& velocity, Time valid_until) override {
    require_connection("command");
    if (!is_finite(velocity)) {
      throw ContractError(fmt::format("{}: a velocity of ({}, {}, {}) is not finite", profile_.name, velocity.vx,
                                      velocity.vy, velocity.omega));
    }
    if (profile_.kinematics() == Kinematics::differential && velocity.vy != 0.0) {
      throw ContractError(
          fmt::format("{}: vy is {} m/s, but a differential base cannot drive sideways", profile_.name, velocity.vy));
    }
    state_.command = velocity;
    state_.valid_until = valid_until;
  }

  // For the world that holds the port.

  /// What the robot is told to do in a step that begins at `t`: nothing once the command has expired.
  Velocity command_at(Time t) const { return t < state_.valid_until ? state_.command : Velocity{}; }

  void reset() {
    state_ = {};
    state_.sequences.assign(features_.sensors.size(), 0);
  }

  void save(ByteWriter& bytes) const {
    bytes.put(state_.command);
    bytes.put(state_.valid_until);
    for (const std::uint64_t sequence : state_.sequences) bytes.put(sequence);
    bytes.put(std::uint64_t{state_.arrivals.size()});
    for (const auto& [time, sample, recipe] : state_.arrivals) {
      bytes.put(time);
      bytes.put(sample);
      put(bytes, recipe);
    }
  }
  /// What was saved of a port with the same sensors; changes nothing.
  State load(ByteReader& bytes) const {
    State state;
    bytes.get(state.command);
    bytes.get(state.valid_until);
    state.sequences.assign(features_.sensors.size(), 0);
    for (std::uint64_t& sequence : state.sequences) bytes.get(sequence);
    state.arrivals.resize(bytes.get_size());
    for (auto& [time, sample, recipe] : state.arrivals) {
      bytes.get(time);
      bytes.get(sample);
      get(bytes, sample, recipe);
    }
    return state;
  }
  void restore(State state) { state_ = std::move(state); }

 protected:
  bool connected() const { return connected_; }

  /// Sends a sample on, which arrives at `arrival`.
  void send(std::size_t sensor, Time measured, Time arrival, SampleData data, Recipe recipe = {}) {
    // what arrives at one moment keeps the order in which it was sent
    const auto later = std::ranges::find_if(state_.arrivals, [&](const auto& other) { return other.time > arrival; });
    state_.arrivals.insert(
        later, {arrival, {static_cast<std::uint16_t>(sensor), 0, measured, {}, std::move(data)}, std::move(recipe)});
  }

 private:
  /// Makes a sample that has arrived complete; its recipe may be taken apart.
  virtual void finish(Sample&, Recipe&) const {}
  virtual void put(ByteWriter&, const Recipe&) const {}
  virtual void get(ByteReader&, const Sample&, Recipe&) const {}

  void require_connection(const char* call) const {
    if (!connected_) throw ConnectionError(fmt::format("{}: {}() needs connect() first", profile_.name, call));
  }

  const World& world_;
  RobotProfile profile_;  // as its maker states it, whatever the noise
  Features features_;
  bool connected_ = false;
  State state_;
};

}  // namespace threewe::backend
