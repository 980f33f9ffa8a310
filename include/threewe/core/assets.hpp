// Asset search path: folders of scenes, objects, robots, localization models, randomizations and log specifications.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace threewe {

/// The folders that hold `scenes/`, `objects/`, `robots/`, `localization/`, `randomization/` and `logs/`: the one
/// installed with the library (or in its place the one that the environment variable THREEWE_ASSETS names), those of
/// other people in THREEWE_PATH (colon-separated), then those added at run time. Throws ConfigError where THREEWE_PATH
/// names something that is no such folder.
std::vector<std::filesystem::path> asset_directories();
/// Adds a folder to search. Throws ConfigError when it holds none of those folders.
void add_asset_directory(const std::filesystem::path& directory);

/// The file of an asset: `kind` is "scenes", "objects", "robots", "localization", "randomization" or "logs"; `name`
/// is a name or a path that ends in .yaml. Throws ConfigError naming the nearest right name, or both files where two
/// folders have one of this name: what a name means must not depend on the order of folders.
std::filesystem::path find_asset(std::string_view kind, std::string_view name);
/// The names of all assets of a kind, sorted.
std::vector<std::string> asset_names(std::string_view kind);

}  // namespace threewe
