// The robot of a MuJoCo world, as a runtime sees it.
#pragma once

#include <variant>

#include "backend/mujoco/world/mujoco_truth.hpp"
#include "backend/simulated_port.hpp"

namespace threewe::backend::mujoco {

class MujocoWorld;

/// Without a camera: who asks for one hears that the robot has none here.
class MujocoPort : public SimulatedPort<std::monostate> {
 public:
  MujocoPort(const MujocoWorld& world, const RobotProfile& profile);

  const scene::TruthView* truth() const override { return &truth_; }
  /// For the world: sends on what became ready in the step that it has just taken.
  void collect();

 private:
  const MujocoWorld& world_;
  MujocoTruth truth_;
};

}  // namespace threewe::backend::mujoco
