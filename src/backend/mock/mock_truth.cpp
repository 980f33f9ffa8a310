#include "backend/mock/mock_truth.hpp"

#include "threewe/sim/camera.hpp"

namespace threewe::backend::mock {

const scene::SceneTables& MockTruth::tables() const {
  if (!tables_) {
    const RobotProfile& profile = model_->robots[index_].profile;
    tables_ = std::make_unique<scene::SceneTables>(model_->scene, profile.body.footprint, profile.body.height);
  }
  return *tables_;
}

std::vector<scene::PersonPose> MockTruth::people() const {
  std::vector<scene::PersonPose> people;
  for (std::size_t i = 0; i < people_.size(); ++i) {
    const scene::Person& person = model_->scene->people[i];
    const auto& [circle, direction] = sim::place_on(person, people_[i]);
    people.push_back(
        {person.name, {circle.center.x, circle.center.y, exact::atan2(direction.y, direction.x)}, person.radius});
  }
  return people;
}

Pose2D MockTruth::sample_free_pose(std::uint64_t seed) const { return tables().sample_free_pose(seed); }

SemanticImage MockTruth::look(const CameraIntrinsics& camera, const Pose2D& pose, double height,
                              bool with_itself) const {
  return sim::draw_truth(*model_, sim::take_shot(states_, people_, index_), camera, {pose, height}, with_itself);
}

double MockTruth::geodesic(Vec2 a, Vec2 b) const {
  if (!field_ || field_->target() != b) {
    field_ = std::make_unique<scene::GeodesicField>(tables().geodesic_field(b));
  }
  return field_->length_from(a);
}

}  // namespace threewe::backend::mock
