// The truth about a robot that is simulated in Python.
#pragma once

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "backend/plugin.hpp"
#include "scene/table_truth.hpp"
#include "sim/camera.hpp"
#include "sim/model.hpp"

/// What the plug-in answers, and what follows from its scene. People are where it has them, of which nobody tells.
class PluginTruthView final : public threewe::scene::TableTruth {
 public:
  PluginTruthView(std::shared_ptr<threewe::backend::PluginLink> link,
                  std::shared_ptr<const threewe::scene::Scene> scene)
      : TableTruth(scene, link->profile().body.footprint, link->profile().body.height),
        scene_(std::move(scene)),
        link_(std::move(link)) {}

  threewe::Pose2D true_pose() const override { return link_->truth().pose; }
  threewe::Velocity true_velocity() const override { return link_->truth().velocity; }
  threewe::Pose2D start_pose() const override { return link_->truth().start; }
  double max_collision_speed() const override { return link_->truth().max_collision_speed; }
  double distance_driven() const override { return link_->truth().distance_driven; }
  std::vector<threewe::scene::PersonPose> people() const override { return {}; }

  /// Drawn by our own renderer, of what stands in the scene.
  threewe::SemanticImage look(const threewe::CameraIntrinsics& camera, const threewe::Pose2D& pose, double height,
                              bool with_itself) const override {
    std::call_once(drawn_, [this] { model_ = threewe::sim::make_model(scene_, {link_->profile()}); });
    threewe::sim::CapturePose capture;
    capture.robots = {true_pose()};
    return threewe::sim::draw_truth(*model_, capture, camera, {pose, height}, with_itself);
  }

 private:
  std::shared_ptr<const threewe::scene::Scene> scene_;
  std::shared_ptr<threewe::backend::PluginLink> link_;
  mutable std::once_flag drawn_;
  mutable std::shared_ptr<const threewe::sim::Model> model_;
};
