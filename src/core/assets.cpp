#include "threewe/core/assets.hpp"

#include <algorithm>
#include <cstdlib>
#include <mutex>
#include <sstream>

#include <fmt/format.h>

#include "threewe/core/errors.hpp"
#include "threewe/core/names.hpp"

namespace threewe {
namespace {

namespace fs = std::filesystem;

std::mutex added_mutex;
std::vector<fs::path> added_directories;

bool names_a_file(std::string_view name) { return name.ends_with(".yaml") || name.ends_with(".yml"); }

// "scenes" -> "scene", for messages
std::string_view singular(std::string_view kind) { return kind.substr(0, kind.size() - 1); }

}  // namespace

std::vector<fs::path> asset_directories() {
  std::vector<fs::path> directories;
  if (const char* paths = std::getenv("THREEWE_ASSETS")) {
    std::istringstream stream(paths);
    for (std::string path; std::getline(stream, path, ':');) {
      if (!path.empty()) directories.emplace_back(path);
    }
  }
  const std::scoped_lock lock(added_mutex);
  directories.insert(directories.end(), added_directories.begin(), added_directories.end());
  directories.emplace_back(THREEWE_ASSET_DIR);
  return directories;
}

void add_asset_directory(const fs::path& directory) {
  const std::scoped_lock lock(added_mutex);
  if (std::ranges::find(added_directories, directory) == added_directories.end())
    added_directories.push_back(directory);
}

std::vector<std::string> asset_names(std::string_view kind) {
  std::vector<std::string> names;
  for (const fs::path& directory : asset_directories()) {
    std::error_code missing;
    for (const auto& entry : fs::directory_iterator(directory / kind, missing)) {
      if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
    }
  }
  std::ranges::sort(names);
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

fs::path find_asset(std::string_view kind, std::string_view name) {
  if (names_a_file(name)) {
    if (fs::is_regular_file(name)) return name;
    throw ConfigError(fmt::format("{} file '{}' does not exist", singular(kind), name));
  }
  for (const fs::path& directory : asset_directories()) {
    const fs::path file = directory / kind / fmt::format("{}.yaml", name);
    if (name.find('/') == std::string_view::npos && fs::is_regular_file(file)) return file;
  }
  const auto names = asset_names(kind);
  throw ConfigError(unknown_name(singular(kind), name, names));
}

}  // namespace threewe
