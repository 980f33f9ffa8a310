// The truth about one simulated robot.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "threewe/scene/table_truth.hpp"
#include "threewe/sim/model.hpp"
#include "threewe/sim/people.hpp"
#include "threewe/sim/state.hpp"

namespace threewe::backend::mock {

class MockTruth : public scene::TableTruth {
 public:
  MockTruth(std::shared_ptr<const sim::Model> model, std::size_t index, const std::vector<sim::RobotState>& states,
            const std::vector<sim::PersonState>& people)
      : TableTruth(model->scene, model->robots[index].profile.body.footprint, model->robots[index].profile.body.height),
        model_(std::move(model)),
        index_(index),
        states_(states),
        people_(people) {}

  Pose2D true_pose() const override { return state().pose; }
  Velocity true_velocity() const override { return state().velocity; }
  Pose2D start_pose() const override { return state().start; }
  double max_collision_speed() const override { return state().max_collision_speed; }
  double distance_driven() const override { return state().distance_driven; }
  std::vector<scene::PersonPose> people() const override;
  SemanticImage look(const CameraIntrinsics& camera, const Pose2D& pose, double height,
                     bool with_itself) const override;

 private:
  const sim::RobotState& state() const { return states_[index_]; }

  std::shared_ptr<const sim::Model> model_;
  std::size_t index_;
  const std::vector<sim::RobotState>& states_;   // the world's
  const std::vector<sim::PersonState>& people_;  // likewise
};

}  // namespace threewe::backend::mock
