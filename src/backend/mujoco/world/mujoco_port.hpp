// The robot of a MuJoCo world, as a runtime sees it.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "backend/bytes.hpp"
#include "backend/mujoco/world/mujoco_truth.hpp"
#include "threewe/backend/world.hpp"

namespace threewe::backend::mujoco {

class MujocoWorld;

/// What a port knows beyond the simulated robot: the command in force, and samples on their way.
struct PortState {
  struct Arrival {
    Time time;
    Sample sample;
  };

  Velocity command;
  Time valid_until{};
  std::vector<Arrival> arrivals;         ///< by time
  std::vector<std::uint64_t> sequences;  ///< the next number of each sensor

  void save(ByteWriter& bytes) const;
  void load(ByteReader& bytes, std::size_t sensors);
};

class MujocoPort : public RobotPort {
 public:
  MujocoPort(const MujocoWorld& world, RobotProfile profile);

  const Features& features() const override { return features_; }
  const RobotProfile& profile() const override { return profile_; }
  void connect() override { connected_ = true; }
  void disconnect() override;
  std::vector<Sample> poll() override;
  void command(const Velocity& velocity, Time valid_until) override;
  const scene::TruthView* truth() const override { return &truth_; }

  // For the world that holds the port.

  /// What the robot is told to do in a step that begins at `t`: nothing once the command has expired.
  Velocity command_at(Time t) const { return t < state_.valid_until ? state_.command : Velocity{}; }
  /// Sends on what became ready in the step that the world has just taken.
  void collect();
  void reset();
  const PortState& state() const { return state_; }
  void restore(PortState state) { state_ = std::move(state); }

 private:
  void send(std::size_t sensor, Time measured, Duration latency, SampleData data);

  const MujocoWorld& world_;
  RobotProfile profile_;  // as its maker states it, whatever the noise
  Features features_;
  MujocoTruth truth_;
  bool connected_ = false;
  PortState state_;
};

}  // namespace threewe::backend::mujoco
