// Files: what is written where, and what is refused.
#include "threewe/export/export.hpp"

#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

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
