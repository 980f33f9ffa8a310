#include "threewe/export/export.hpp"

#include <array>
#include <fstream>
#include <system_error>

#include <fmt/format.h>

#include "core/names.hpp"
#include "export/mjcf.hpp"
#include "threewe/core/errors.hpp"
#include "writers.hpp"

namespace threewe::exports {
namespace {

constexpr std::array kNames = {"mjcf", "urdf", "sdf", "usd", "map"};  // in the order of Format

std::vector<File> mjcf_files(const scene::Scene& scene, const RobotDescription& robot) {
  const std::array robots = {PlacedRobot{.name = "robot", .description = robot, .scene_from_base = {}}};
  return {{"scene.xml", mjcf(scene, robots)}};
}

}  // namespace

std::vector<std::string> format_names() { return {kNames.begin(), kNames.end()}; }

Format format_named(std::string_view name) {
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    if (name == kNames[i]) return static_cast<Format>(i);
  }
  throw ConfigError(unknown_name("format", name, format_names()));
}

// Names become names of files and of elements.
std::vector<File> files(const scene::Scene& scene, const RobotProfile& robot, Format format) {
  for (const std::string& name : {scene.name, robot.name}) {
    if (!is_name(name)) throw ConfigError(fmt::format("export: {}", not_a_name(name)));
  }
  switch (format) {
    case Format::mjcf: return mjcf_files(scene, describe(robot));
    case Format::urdf: return urdf_files(scene, without_rollers(describe(robot)));
    case Format::sdf: return sdf_files(scene, without_rollers(describe(robot)));
    case Format::usd: return usd_files(scene, describe(robot));
    case Format::map: return map_files(scene, robot);
  }
  return {};
}

std::vector<std::filesystem::path> write(const std::vector<File>& files, const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> written;
  for (const auto& [name, contents] : files) {
    const std::filesystem::path path = folder / name;
    std::error_code failure;
    std::filesystem::create_directories(path.parent_path(), failure);
    if (failure) {
      throw ConfigError(fmt::format("cannot make the folder '{}': {}", path.parent_path().string(), failure.message()));
    }
    std::ofstream file(path, std::ios::binary);
    file << contents;
    file.close();
    if (!file) throw ConfigError(fmt::format("cannot write '{}'", path.string()));
    written.push_back(path);
  }
  return written;
}

}  // namespace threewe::exports
