// Scenes and objects with random mistakes: each loads, or is refused with its file and line.
#include <doctest/doctest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "mistakes.hpp"
#include "threewe/core/assets.hpp"
#include "threewe/scene/scene.hpp"

namespace threewe::scene {
namespace {

std::string text_of(std::string_view kind, std::string_view name) {
  std::ostringstream text;
  text << std::ifstream(find_asset(kind, name)).rdbuf();
  return text.str();
}

constexpr std::uint64_t kCases = 50;  // of each file

TEST_CASE("scenes with mistakes") {
  for (const std::string& name : scene_names()) {
    CAPTURE(name);
    const std::string text = text_of("scenes", name);
    for (std::uint64_t seed = 0; seed < kCases; ++seed) {
      testing::read_with_mistakes(text, seed, {"a.yaml:"}, [](const std::string& t) { Scene::parse(t, "a.yaml"); });
    }
  }
}

TEST_CASE("objects with mistakes") {
  const auto folder = std::filesystem::temp_directory_path() / "threewe_mistakes_test";
  std::filesystem::create_directories(folder / "objects");
  add_asset_directory(folder);
  const std::filesystem::path file = folder / "objects/mutant.yaml";
  const std::string hall =
      "name: hall\ndescription: a hall\nstarts: [[1, 1]]\nwalls: [{a: [0, 0], b: [30, 0]}, {a: [30, 30], b: [0, 30]}]\n"
      "objects: [{category: mutant, shape: SHAPE, pose: [15, 15]}]\n";
  for (const std::string& name : asset_names("objects")) {
    if (name == "mutant") continue;
    CAPTURE(name);
    const std::string text = text_of("objects", name);
    const std::string shape = text.substr(text.find("shapes:\n  ") + 10);
    std::string scene = hall;
    scene.replace(scene.find("SHAPE"), 5, shape.substr(0, shape.find(':')));
    std::string mutant = text;
    mutant.replace(mutant.find("category: " + name), 10 + name.size(), "category: mutant");
    for (std::uint64_t seed = 0; seed < kCases; ++seed) {
      testing::read_with_mistakes(mutant, seed, {"hall.yaml:", file.string() + ":"}, [&](const std::string& t) {
        std::ofstream(file) << t;
        Scene::parse(scene, "hall.yaml");
      });
    }
  }
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace threewe::scene
