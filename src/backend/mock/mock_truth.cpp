#include "backend/mock/mock_truth.hpp"

#include "threewe/sim/camera.hpp"

namespace threewe::backend::mock {

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

SemanticImage MockTruth::look(const CameraIntrinsics& camera, const Pose2D& pose, double height,
                              bool with_itself) const {
  return sim::draw_truth(*model_, sim::take_shot(states_, people_, index_), camera, {pose, height}, with_itself);
}

}  // namespace threewe::backend::mock
