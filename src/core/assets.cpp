#include "threewe/core/assets.hpp"

#include <dlfcn.h>

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

// A relative folder is one beside the file that this code was loaded from: a wheel may be unpacked anywhere.
fs::path installed_directory() {
  fs::path directory = THREEWE_ASSET_DIR;
  Dl_info loaded{};
  if (directory.is_absolute() || dladdr(&added_mutex, &loaded) == 0) return directory;
  return fs::absolute(loaded.dli_fname).parent_path() / directory;
}

// "scenes" -> "scene", for messages
std::string_view singular(std::string_view kind) { return kind.substr(0, kind.size() - 1); }

// Two ways of writing one folder count as one.
void add_once(std::vector<fs::path>& directories, const fs::path& directory) {
  const auto same = [&](const fs::path& other) {
    std::error_code missing;
    return other == directory || fs::equivalent(other, directory, missing);
  };
  if (std::ranges::none_of(directories, same)) directories.push_back(directory);
}

}  // namespace

std::vector<fs::path> asset_directories() {
  const char* elsewhere = std::getenv("THREEWE_ASSETS");
  std::vector<fs::path> directories = {elsewhere != nullptr ? fs::path(elsewhere) : installed_directory()};
  if (const char* paths = std::getenv("THREEWE_PATH")) {
    std::istringstream stream(paths);
    for (std::string path; std::getline(stream, path, ':');) {
      if (path.empty()) continue;
      if (!fs::is_directory(path)) throw ConfigError(fmt::format("THREEWE_PATH: '{}' is not a folder", path));
      add_once(directories, path);
    }
  }
  const std::scoped_lock lock(added_mutex);
  for (const fs::path& path : added_directories) add_once(directories, path);
  return directories;
}

void add_asset_directory(const fs::path& directory) {
  if (!fs::is_directory(directory)) throw ConfigError(fmt::format("'{}' is not a folder", directory.string()));
  const std::scoped_lock lock(added_mutex);
  add_once(added_directories, directory);
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
  std::error_code unusable;  // as where the name is too long for a file's
  if (names_a_file(name)) {
    if (fs::is_regular_file(name, unusable)) return name;
    throw ConfigError(fmt::format("{} file '{}' does not exist", singular(kind), name));
  }
  if (name.find('/') == std::string_view::npos) {
    std::vector<fs::path> files;
    for (const fs::path& directory : asset_directories()) {
      const fs::path file = directory / kind / fmt::format("{}.yaml", name);
      if (fs::is_regular_file(file, unusable)) files.push_back(file);
    }
    if (files.size() > 1) {
      throw ConfigError(fmt::format("there are two {} named '{}': {} and {}; rename one of them", kind, name,
                                    files[0].string(), files[1].string()));
    }
    if (!files.empty()) return files.front();
  }
  const auto names = asset_names(kind);
  throw ConfigError(unknown_name(singular(kind), name, names));
}

}  // namespace threewe
