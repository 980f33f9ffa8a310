#include "threewe/core/assets.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <cstdlib>
#include <mutex>
#include <sstream>

#include <fmt/format.h>

#include "core/names.hpp"
#include "threewe/core/errors.hpp"

// Defined in programs that were built with the CMake package: see cmake/threewe-config.cmake.in.
extern "C" const char* threewe_package_assets() __attribute__((weak));

namespace threewe {
namespace {

namespace fs = std::filesystem;

std::mutex added_mutex;
std::vector<fs::path> added_directories;

// Editors and archives leave hidden files behind.
bool is_asset(const fs::path& file) {
  std::error_code unreadable;
  return file.extension() == ".yaml" && !file.filename().string().starts_with('.') &&
         fs::is_regular_file(file, unreadable);
}

// `origin` is where the folder was named, for messages.
void check_directory(const fs::path& directory, std::string_view origin) {
  const auto fail = [&](std::string_view what) {
    throw ConfigError(fmt::format("{}'{}' {}", origin, directory.string(), what));
  };
  std::error_code unusable;
  if (!fs::is_directory(directory, unusable)) fail("is not a folder");
  const auto holds = [&](std::string_view kind) { return fs::is_directory(directory / kind, unusable); };
  if (!holds("scenes") && !holds("objects") && !holds("robots") && !holds("localization") && !holds("randomization") &&
      !holds("logs")) {
    fail("has no folder 'scenes', 'objects', 'robots', 'localization', 'randomization' or 'logs' in it");
  }
}

bool names_a_file(std::string_view name) { return name.ends_with(".yaml") || name.ends_with(".yml"); }

// The folder of the library or the program that this code was loaded from; empty where it is not known.
fs::path loaded_from() {
  Dl_info loaded{};
  if (dladdr(&added_mutex, &loaded) == 0) return {};
  std::error_code gone;
  const fs::path file = fs::canonical(loaded.dli_fname, gone);
  return (gone ? fs::absolute(loaded.dli_fname) : file).parent_path();
}

// An installation may be moved, and a wheel unpacked anywhere. So the folder is the one that the CMake package has
// given the program (a program that contains the library is elsewhere), else one that lies where it should as seen from
// the library or from a program installed beside it, else the one known when the library was configured.
fs::path find_installed_directory() {
  std::error_code unusable;
  if (threewe_package_assets != nullptr && fs::is_directory(threewe_package_assets(), unusable)) {
    return threewe_package_assets();
  }
  const fs::path here = loaded_from();
  for (const char* way : {THREEWE_ASSETS_FROM_LIBRARY, THREEWE_ASSETS_FROM_PROGRAM}) {
    const fs::path directory = (here / way).lexically_normal();
    if (fs::is_directory(directory, unusable)) return directory;
  }
  return here / THREEWE_ASSET_DIR;
}

const fs::path& installed_directory() {
  static const fs::path directory = find_installed_directory();
  return directory;
}

// Without the folder of the installation nothing can be found.
void require_installed(const fs::path& directory) {
  std::error_code unusable;
  if (fs::is_directory(directory, unusable)) return;
  throw ConfigError(
      fmt::format("there is no folder '{}' with what was installed with 3we: set THREEWE_ASSETS to where "
                  "the installation has share/threewe/assets",
                  directory.string()));
}

// "scenes" -> "scene", for messages
std::string_view singular(std::string_view kind) { return kind.substr(0, kind.size() - (kind.ends_with('s') ? 1 : 0)); }

// A file that is there, and yet not found, would be a riddle.
void refuse_yml(std::string_view kind, std::string_view name) {
  for (const fs::path& directory : asset_directories()) {
    const fs::path file = directory / kind / fmt::format("{}.yml", name);
    std::error_code unusable;
    if (fs::is_regular_file(file, unusable)) {
      throw ConfigError(fmt::format("rename {}: the names of such files end in .yaml", file.string()));
    }
  }
}

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
      check_directory(path, "THREEWE_PATH: ");
      add_once(directories, path);
    }
  }
  const std::scoped_lock lock(added_mutex);
  for (const fs::path& path : added_directories) add_once(directories, path);
  return directories;
}

void add_asset_directory(const fs::path& directory) {
  check_directory(directory, "");
  const std::scoped_lock lock(added_mutex);
  add_once(added_directories, fs::absolute(directory));
}

std::vector<std::string> asset_names(std::string_view kind) {
  std::vector<std::string> names;
  for (const fs::path& directory : asset_directories()) {
    std::error_code missing;
    for (const auto& entry : fs::directory_iterator(directory / kind, missing)) {
      if (is_asset(entry.path())) names.push_back(entry.path().stem().string());
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
      if (is_asset(file)) files.push_back(file);
    }
    if (files.size() > 1) {
      throw ConfigError(fmt::format("there are two {} named '{}': {} and {}; rename one of them", kind, name,
                                    files[0].string(), files[1].string()));
    }
    if (!files.empty()) return files.front();
    refuse_yml(kind, name);
  }
  require_installed(asset_directories().front());
  const auto names = asset_names(kind);
  throw ConfigError(unknown_name(singular(kind), name, names));
}

}  // namespace threewe
