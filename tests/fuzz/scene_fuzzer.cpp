// Scenes.
#include "fuzz.hpp"
#include "threewe/scene/scene.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace threewe;
  const std::string text(reinterpret_cast<const char*>(data), size);
  fuzz::read(text, [&] {
    const scene::Scene scene = scene::Scene::parse(text, "fuzz.yaml");
    scene::Scene::parse(scene::to_yaml(scene), "written.yaml");  // what is read can be written and read again
  });
  return 0;
}
