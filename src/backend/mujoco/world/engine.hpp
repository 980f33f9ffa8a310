// Simulation engine on MuJoCo's physics.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "backend/mujoco/world/drawer.hpp"
#include "backend/mujoco/world/physics.hpp"
#include "backend/simulated/engine.hpp"

namespace threewe::backend::mujoco {

class MujocoEngine : public simulated::Engine {
 public:
  /// Throws ConfigError where MuJoCo cannot be loaded or refuses the model.
  explicit MujocoEngine(std::shared_ptr<const sim::Model> model);

  void place(std::span<const sim::RobotState> robots, std::span<const sim::PersonState> people) override;
  void teleport(std::size_t robot, const sim::RobotState& state) override { physics_.teleport(robot, state.pose); }
  void vary(std::size_t robot, const sim::RobotState& state) override { physics_.vary(robot, state.variation); }
  void step(std::span<sim::RobotState> robots, std::span<const Velocity> commands,
            std::span<sim::PersonState> people) override;

  std::vector<double> state() const override { return physics_.state(); }
  void restore(std::span<const double> state, std::span<const sim::RobotState> robots) override;

  Picture picture(simulated::WorldCapture capture) const override;
  SemanticImage look(const simulated::WorldCapture& capture, const CameraIntrinsics& camera,
                     const sim::CameraPose& view, bool with_itself) const override;

  const Physics& physics() const { return physics_; }

 private:
  std::shared_ptr<const sim::Model> model_;
  Physics physics_;
  std::shared_ptr<Drawer> drawer_;                 // pictures outlive a world
  std::vector<std::vector<exports::Vec3>> beams_;  // of each robot's lidar
  std::vector<Drive> drives_;                      // of each robot, in the step to come
};

}  // namespace threewe::backend::mujoco
