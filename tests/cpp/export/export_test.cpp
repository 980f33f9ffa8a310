// Files: what is written where, and what is refused.
#include "threewe/export/export.hpp"

#include <doctest/doctest.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include <pugixml.hpp>

#include "export/mjcf.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::exports {
namespace {

namespace fs = std::filesystem;

std::string contents(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

std::string error_of(const auto& action) {
  try {
    action();
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

TEST_CASE("every format of every scene and robot is written, and is the same each time") {
  const fs::path folder = fs::temp_directory_path() / "threewe_export_test";
  fs::remove_all(folder);
  for (const std::string& name : format_names()) {
    const Format format = format_named(name);
    for (const std::string& robot : profile_names()) {
      CAPTURE(name);
      CAPTURE(robot);
      const scene::Scene scene = scene::Scene::load("apartment_v1");
      const std::vector<File> made = files(scene, load_profile(robot), format);
      const std::vector<fs::path> paths = write(made, folder / name / robot);
      REQUIRE(paths.size() == made.size());
      const std::vector<File> again = files(scene, load_profile(robot), format);
      for (std::size_t i = 0; i < made.size(); ++i) {
        CHECK(contents(paths[i]) == made[i].contents);
        CHECK(again[i].contents == made[i].contents);
      }
    }
  }
  fs::remove_all(folder);
}

TEST_CASE("several robots share a MuJoCo model, each under its own name") {
  const scene::Scene scene = scene::Scene::load("apartment_v1");
  const std::array robots = {
      PlacedRobot{.name = "a", .description = describe(load_profile("3we_standard_v2")), .scene_from_base = {}},
      PlacedRobot{.name = "b", .description = describe(load_profile("turtlebot_like")), .scene_from_base = {1, 0, 2}}};
  pugi::xml_document model;
  REQUIRE(model.load_string(mjcf(scene, robots).c_str()));
  for (const char* kind : {"body", "joint", "geom", "site", "camera", "general"}) {
    CAPTURE(kind);
    std::set<std::string> names;
    for (const auto& found : model.select_nodes(("//" + std::string(kind) + "[@name]").c_str())) {
      CHECK(names.insert(found.node().attribute("name").value()).second);
    }
    CHECK_FALSE(names.empty());
  }
  CHECK(model.select_nodes("//actuator/general").size() == 6);
  CHECK(model.select_nodes("//freejoint").size() == 2);
}

TEST_CASE("a format that is none names the nearest") {
  CHECK(error_of([] { format_named("mjfc"); }).find("did you mean 'mjcf'") != std::string::npos);
  CHECK(error_of([] { format_named(""); }).find("format") != std::string::npos);
}

TEST_CASE("a folder that is a file is named in the error") {
  const fs::path file = fs::temp_directory_path() / "threewe_export_test_file";
  std::ofstream(file) << "here";
  const std::string error = error_of([&] { write({{"map.yaml", "x"}}, file); });
  CAPTURE(error);
  CHECK(error.find(file.string()) != std::string::npos);
  CHECK(contents(file) == "here");
  fs::remove(file);
}

}  // namespace
}  // namespace threewe::exports
