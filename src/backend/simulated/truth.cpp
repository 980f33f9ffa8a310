#include "backend/simulated/truth.hpp"
#include "core/exact.hpp"

namespace threewe::backend::simulated {

Truth::Truth(const SimulatedWorld& world, std::size_t index)
    : TableTruth(world.model_->scene, world.model_->robots[index].profile.body.footprint,
                 world.model_->robots[index].profile.body.height),
      world_(world),
      index_(index) {}

std::vector<scene::PersonPose> Truth::people() const {
  std::vector<scene::PersonPose> people;
  for (std::size_t i = 0; i < world_.people_.size(); ++i) {
    const scene::Person& person = world_.model_->scene->people[i];
    const auto& [circle, direction] = sim::place_on(person, world_.people_[i]);
    people.push_back(
        {person.name, {circle.center.x, circle.center.y, exact::atan2(direction.y, direction.x)}, person.radius});
  }
  return people;
}

SemanticImage Truth::look(const CameraIntrinsics& camera, const Pose2D& pose, double height, bool with_itself) const {
  return world_.engine_->look(world_.capture(index_), camera, {pose, height}, with_itself);
}

}  // namespace threewe::backend::simulated
