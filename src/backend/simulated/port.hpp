// Backend port of one simulated robot.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "backend/simulated/simulated_world.hpp"
#include "core/bytes.hpp"

namespace threewe::backend::simulated {

/// What the simulator gives of a robot of this profile.
Features features_of(const RobotProfile& profile);

/// It keeps the command in force and the samples on their way. A picture is made of its moment once it has arrived.
class Port : public RobotPort {
 public:
  /// All of a port that changes while it is connected.
  struct State {
    struct Arrival {
      Time time;
      Sample sample;
      std::optional<WorldCapture> capture;  ///< that a picture was taken of
    };

    Velocity command;
    Time valid_until{};
    std::vector<Arrival> arrivals;         ///< by time
    std::vector<std::uint64_t> sequences;  ///< the next number of each sensor
  };

  Port(const SimulatedWorld& world, std::size_t index, const RobotProfile& profile);

  const Features& features() const override { return features_; }
  const RobotProfile& profile() const override { return profile_; }
  void connect() override { connected_ = true; }
  void disconnect() override;
  std::vector<Sample> poll() override;
  void command(const Velocity& velocity, Time valid_until) override;

  // For the world that holds the port.

  /// What is commanded in a step that begins at `t`: nothing once the command has expired.
  Velocity command_at(Time t) const { return t < state_.valid_until ? state_.command : Velocity{}; }
  /// Sends on what became ready in the step that the world has just taken.
  void collect();
  void reset();
  void save(ByteWriter& bytes) const;
  /// What was saved of a port with the same sensors; changes nothing.
  State load(ByteReader& bytes) const;
  void restore(State state) { state_ = std::move(state); }

 private:
  void send(std::size_t sensor, Time measured, Time arrival, SampleData data, std::optional<WorldCapture> capture = {});
  void require_connection(const char* call) const;

  const SimulatedWorld& world_;
  std::size_t index_;
  RobotProfile profile_;  // as its maker states it, whatever the noise
  Features features_;
  bool connected_ = false;
  State state_;
};

}  // namespace threewe::backend::simulated
