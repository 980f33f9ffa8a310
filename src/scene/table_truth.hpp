// Ground truth that follows from the scene alone.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "scene/scene_tables.hpp"
#include "threewe/core/footprint.hpp"
#include "threewe/scene/scene.hpp"
#include "threewe/scene/solid.hpp"
#include "threewe/scene/truth_view.hpp"

namespace threewe::scene {

/// What can be asked about a scene, for a robot of some footprint and height. Answered from tables that are made when
/// they are first needed: a world without questions starts faster.
class TableTruth : public TruthView {
 public:
  TableTruth(std::shared_ptr<const Scene> scene, Footprint footprint, double robot_height)
      : scene_(std::move(scene)), footprint_(std::move(footprint)), robot_height_(robot_height) {}

  const Scene& scene() const override { return *scene_; }
  Pose2D sample_free_pose(std::uint64_t seed) const override { return tables().sample_free_pose(seed); }
  double range(const Pose2D& pose, double height) const override {
    if (!slice_ || slice_height_ != height) slice_ = scene_->at_height(slice_height_ = height);
    return cast_ray(*slice_, pose.position(), pose.theta, std::numeric_limits<double>::infinity());
  }
  double geodesic(Vec2 a, Vec2 b) const override {
    if (!field_ || field_->target() != b) field_ = std::make_unique<GeodesicField>(tables().geodesic_field(b));
    return field_->length_from(a);
  }

 private:
  const SceneTables& tables() const {
    if (!tables_) tables_ = std::make_unique<SceneTables>(scene_, footprint_, robot_height_);
    return *tables_;
  }

  std::shared_ptr<const Scene> scene_;
  Footprint footprint_;
  double robot_height_;
  mutable std::unique_ptr<SceneTables> tables_;
  mutable std::unique_ptr<GeodesicField> field_;  // to the target asked for last
  mutable std::optional<Slice> slice_;            // at the height asked for last
  mutable double slice_height_ = 0.0;
};

}  // namespace threewe::scene
