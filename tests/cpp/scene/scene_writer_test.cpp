// What is written reads back equal.
#include <doctest/doctest.h>

#include "threewe/scene/scene.hpp"

namespace threewe::scene {
namespace {

TEST_CASE("every shipped scene reads back equal") {
  for (const std::string& name : scene_names()) {
    CAPTURE(name);
    const Scene scene = Scene::load(name);
    CHECK(Scene::parse(to_yaml(scene), "written.yaml") == scene);
  }
}

TEST_CASE("names with all kinds of characters survive") {
  Scene scene = Scene::load("outdoor_v1");
  scene.description = "it's \"quoted\": a\\b, #1 {x} [y]\ttab\nline, 3.5 \xc3\xa9t\xc3\xa9";
  scene.rooms.front().name = "1.5";
  scene.rooms.back().name = "yes: no";
  CHECK(Scene::parse(to_yaml(scene), "written.yaml") == scene);
}

}  // namespace
}  // namespace threewe::scene
