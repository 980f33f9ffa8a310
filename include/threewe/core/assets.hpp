// Where scenes, objects and robots are found.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace threewe {

/// The folders that hold `scenes/`, `objects/` and `robots/`, first match wins: the environment variable
/// THREEWE_ASSETS (colon-separated), folders added at run time, then the folder installed with the library.
std::vector<std::filesystem::path> asset_directories();
/// Adds a folder to search, before the installed one.
void add_asset_directory(const std::filesystem::path& directory);

/// The file of an asset: `kind` is "scenes", "objects" or "robots"; `name` is a name or a path that ends in .yaml.
/// Throws ConfigError naming the nearest right name.
std::filesystem::path find_asset(std::string_view kind, std::string_view name);
/// The names of all assets of a kind, sorted.
std::vector<std::string> asset_names(std::string_view kind);

}  // namespace threewe
