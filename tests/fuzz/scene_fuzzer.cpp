// Scenes.
#include "fuzz.hpp"
#include "threewe/scene/scene.hpp"

THREEWE_FUZZER(scene)(std::string_view input) {
  using namespace threewe;
  const std::string text(input);
  fuzz::read(text, [&] {
    const scene::Scene scene = scene::Scene::parse(text, "fuzz.yaml");
    scene::Scene::parse(scene::to_yaml(scene), "written.yaml");  // what is read can be written and read again
  });
}
