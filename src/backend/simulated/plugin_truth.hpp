// Ground truth of a robot that a plug-in simulates in one of our scenes.
#pragma once

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "backend/plugin.hpp"
#include "scene/table_truth.hpp"
#include "sim/camera.hpp"
#include "sim/model.hpp"

namespace threewe::backend::simulated {

/// What the plug-in answers, and what follows from its scene. Its people are not known.
class PluginTruthView : public scene::TableTruth {
 public:
  PluginTruthView(std::shared_ptr<PluginLink> link, std::shared_ptr<const scene::Scene> scene)
      : TableTruth(scene, link->profile().body.footprint, link->profile().body.height),
        scene_(std::move(scene)),
        link_(std::move(link)) {}

  Pose2D true_pose() const override { return link_->truth().pose; }
  Velocity true_velocity() const override { return link_->truth().velocity; }
  Pose2D start_pose() const override { return link_->truth().start; }
  double max_collision_speed() const override { return link_->truth().max_collision_speed; }
  double distance_driven() const override { return link_->truth().distance_driven; }
  std::vector<scene::PersonPose> people() const override { return {}; }

  /// Drawn by our own renderer, of what stands in the scene.
  SemanticImage look(const CameraIntrinsics& camera, const Pose2D& pose, double height,
                     bool with_itself) const override {
    std::call_once(drawn_, [this] { model_ = sim::make_model(scene_, {link_->profile()}); });
    sim::CapturePose capture;
    capture.robots = {true_pose()};
    return sim::draw_truth(*model_, capture, camera, {pose, height}, with_itself);
  }

 private:
  std::shared_ptr<const scene::Scene> scene_;
  std::shared_ptr<PluginLink> link_;
  mutable std::once_flag drawn_;
  mutable std::shared_ptr<const sim::Model> model_;
};

}  // namespace threewe::backend::simulated
