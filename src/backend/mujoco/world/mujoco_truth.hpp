// The truth about a robot in MuJoCo.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "backend/mujoco/world/physics.hpp"
#include "backend/mujoco/world/robot.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/scene/table_truth.hpp"

namespace threewe::backend::mujoco {

class MujocoTruth : public scene::TableTruth {
 public:
  MujocoTruth(std::shared_ptr<const scene::Scene> scene, const Body& body, const Physics& physics,
              const RobotState& state)
      : TableTruth(std::move(scene), body.footprint, body.height), physics_(physics), state_(state) {}

  Pose2D true_pose() const override { return physics_.pose(); }
  Velocity true_velocity() const override { return physics_.velocity(); }
  Pose2D start_pose() const override { return state_.start; }
  double max_collision_speed() const override { return state_.max_collision_speed; }
  double distance_driven() const override { return state_.distance_driven; }
  std::vector<scene::PersonPose> people() const override { return {}; }
  SemanticImage look(const CameraIntrinsics&, const Pose2D&, double, bool) const override {
    throw HardwareError("backend 'mujoco' draws no pictures yet: 'mock' does");
  }

 private:
  const Physics& physics_;   // the world's
  const RobotState& state_;  // likewise
};

}  // namespace threewe::backend::mujoco
