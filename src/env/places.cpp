#include "env/places.hpp"

#include "threewe/scene/scene_tables.hpp"

namespace threewe::env {

Places make_places(const Options& options) {
  RobotProfile profile = options.hardware;
  if (profile.camera) {
    profile.camera->width = options.image_width;
    profile.camera->height = options.image_height;
  }
  const std::vector<RobotProfile> robots(options.robots, profile);
  Places places;
  for (const auto& scene : options.scenes) {
    places.tables.push_back(
        std::make_shared<const scene::SceneTables>(scene, profile.body.footprint, profile.body.height));
    places.models.push_back(sim::make_model(scene, robots));
  }
  return places;
}

}  // namespace threewe::env
