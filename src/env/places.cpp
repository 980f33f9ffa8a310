#include "env/places.hpp"

#include "scene/scene_tables.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe::env {

Places make_places(const Options& options) {
  const RobotProfile profile = with_image_size(options.hardware, {options.image_width, options.image_height});
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
