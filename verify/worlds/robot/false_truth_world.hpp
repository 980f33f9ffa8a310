// A simulator that falsifies the truth about its robots and people, to show that robots do not use it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <memory>
#include <utility>
#include <vector>

#include "threewe/backend/world.hpp"
#include "threewe/scene/scene.hpp"
#include "threewe/scene/truth_view.hpp"

namespace threewe {

/// The truth, moved by 100 m and turned; and people and things under one another's names.
class FalseTruth final : public scene::TruthView {
 public:
  explicit FalseTruth(const scene::TruthView& truth) : truth_(truth), scene_(truth.scene()) {
    scramble(scene_.people);
    scramble(scene_.objects);
    for (std::size_t i = 0; i + 1 < scene_.objects.size(); ++i)
      std::swap(scene_.objects[i].category, scene_.objects[i + 1].category);
    for (scene::Object& object : scene_.objects) object.pose = shifted(object.pose);
  }
  const scene::Scene& scene() const override { return scene_; }
  Pose2D true_pose() const override { return shifted(truth_.true_pose()); }
  Velocity true_velocity() const override { return {}; }
  Pose2D start_pose() const override { return shifted(truth_.start_pose()); }
  double max_collision_speed() const override { return 7.0; }
  double distance_driven() const override { return truth_.distance_driven() + 100.0; }
  std::vector<scene::PersonPose> people() const override {
    std::vector<scene::PersonPose> people = truth_.people();
    scramble(people);
    for (scene::PersonPose& person : people) person.pose = shifted(person.pose);
    return people;
  }
  Pose2D sample_free_pose(std::uint64_t seed) const override { return shifted(truth_.sample_free_pose(seed)); }
  SemanticImage look(const CameraIntrinsics& camera, const Pose2D&, double height, bool) const override {
    SemanticImage image = truth_.look(camera, {}, height, true);
    std::ranges::reverse(image.names);
    return image;
  }
  double range(const Pose2D& pose, double height) const override { return truth_.range(pose, height) + 1.0; }
  double geodesic(Vec2 a, Vec2 b) const override { return truth_.geodesic(a, b) + 100.0; }

 private:
  static Pose2D shifted(const Pose2D& p) { return {p.x + 100.0, p.y - 100.0, wrap_angle(p.theta + 2.0)}; }
  // each goes by the name of the next
  template <typename Named>
  static void scramble(Named& named) {
    for (std::size_t i = 0; i + 1 < named.size(); ++i) std::swap(named[i].name, named[i + 1].name);
  }

  const scene::TruthView& truth_;
  scene::Scene scene_;
};

/// A world that falsifies the truth about its robots. What they sense and obey is as it was.
class FalseTruthWorld final : public backend::World, private backend::TruthService {
 public:
  explicit FalseTruthWorld(std::unique_ptr<backend::World> world) : world_(std::move(world)) {
    for (std::size_t i = 0; i < world_->robot_count(); ++i) truths_.emplace_back(world_->truth_service()->truth(i));
  }
  std::size_t robot_count() const override { return world_->robot_count(); }
  backend::RobotPort& robot(std::size_t index) override { return world_->robot(index); }
  const backend::TruthService* truth_service() const override { return this; }
  Time now() const override { return world_->now(); }
  void advance_to(Time t) override { world_->advance_to(t); }

 private:
  const scene::TruthView& truth(std::size_t index) const override { return truths_.at(index); }

  std::unique_ptr<backend::World> world_;
  std::deque<FalseTruth> truths_;
};

}  // namespace threewe
