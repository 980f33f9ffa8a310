// Ground truth of one simulated robot.
#pragma once

#include <cstddef>
#include <vector>

#include "backend/simulated/simulated_world.hpp"
#include "scene/table_truth.hpp"

namespace threewe::backend::simulated {

class Truth : public scene::TableTruth {
 public:
  Truth(const SimulatedWorld& world, std::size_t index);

  Pose2D true_pose() const override { return state().pose; }
  Velocity true_velocity() const override { return state().velocity; }
  Pose2D start_pose() const override { return state().start; }
  double max_collision_speed() const override { return state().max_collision_speed; }
  double distance_driven() const override { return state().distance_driven; }
  std::vector<scene::PersonPose> people() const override;
  SemanticImage look(const CameraIntrinsics& camera, const Pose2D& pose, double height,
                     bool with_itself) const override;

 private:
  const sim::RobotState& state() const { return world_.states_[index_]; }

  const SimulatedWorld& world_;
  std::size_t index_;
};

}  // namespace threewe::backend::simulated
