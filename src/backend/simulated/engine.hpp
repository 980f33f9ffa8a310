// Simulation engine interface: body dynamics, ray casts and rendering of one world.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "sim/camera.hpp"
#include "sim/people.hpp"
#include "sim/state.hpp"
#include "threewe/core/camera.hpp"

namespace threewe::backend::simulated {

/// A moment of a world: all that a picture shows follows from it and from what never changes.
struct WorldCapture {
  sim::CapturePose state;
  std::vector<double> physics;  ///< the engine's own, see `Engine::state`
};

/// Moves the robots and people of one world, and lets them look around. What they carry is the world's, and given anew
/// at each call: an engine changes it in `step` alone.
class Engine {
 public:
  Engine() = default;
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;
  virtual ~Engine() = default;

  /// All stand at rest where the states say.
  virtual void place(std::span<const sim::RobotState> robots, std::span<const sim::PersonState> people) = 0;
  /// One robot has been put down elsewhere, where it stands still.
  virtual void teleport(std::size_t robot, const sim::RobotState& state) = 0;
  /// A robot differs from its profile in another way than before, see `sim::vary`.
  virtual void vary(std::size_t robot, const sim::RobotState& state) = 0;
  /// Moves everything on by `sim::kStep`, and takes what sensors read at its end.
  virtual void step(std::span<sim::RobotState> robots, std::span<const Velocity> commands,
                    std::span<sim::PersonState> people) = 0;

  /// What the future depends on beyond the states.
  virtual std::vector<double> state() const = 0;
  /// Throws ContractError where `state` is not of this engine.
  virtual void restore(std::span<const double> state, std::span<const sim::RobotState> robots) = 0;

  /// What the camera of a moment's robot delivers.
  virtual Picture picture(WorldCapture capture) const = 0;
  /// What some camera would truly show of it, with or without the robot itself.
  virtual SemanticImage look(const WorldCapture& capture, const CameraIntrinsics& camera, const sim::CameraPose& view,
                             bool with_itself) const = 0;
};

}  // namespace threewe::backend::simulated
