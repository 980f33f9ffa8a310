// Categories of objects, each in a scene.
#include "fuzz.hpp"
#include "threewe/core/assets.hpp"
#include "threewe/scene/scene.hpp"

THREEWE_FUZZER(object)(std::string_view text) {
  using namespace threewe;
  static const auto file = [] {
    std::filesystem::create_directories(fuzz::folder() / "objects");
    add_asset_directory(fuzz::folder());
    return fuzz::folder() / "objects" / "fuzz.yaml";
  }();
  static const std::string hall =
      "name: hall\ndescription: a hall\nstarts: [[1, 1]]\nwalls: [{a: [0, 0], b: [30, 0]}, {a: [30, 30], b: [0, 30]}]\n"
      "objects: [{category: fuzz, shape: one, pose: [15, 15]}]\n";
  fuzz::write(file, text);
  fuzz::read(text, [&] { scene::Scene::parse(hall, "hall.yaml"); });
}
