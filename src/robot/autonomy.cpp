#include "threewe/robot/world.hpp"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include "core/names.hpp"
#include "threewe/core/errors.hpp"

namespace threewe {

Autonomy autonomy_with(std::string_view localization, std::string_view navigation) {
  const auto require_known = [](std::string_view kind, std::string_view name, const std::vector<std::string>& names) {
    if (std::ranges::find(names, name) == names.end()) throw ConfigError(unknown_name(kind, name, names));
  };
  require_known("localization", localization, {"slam", "truth", "amcl", "slam_toolbox"});
  require_known("navigation", navigation, {"own", "nav2"});
  if (navigation == "nav2" && (localization == "slam" || localization == "truth")) {
    throw ConfigError(
        fmt::format("navigation 'nav2' has its goals in the map of 'amcl' or 'slam_toolbox': localization must be one "
                    "of these, not "
                    "'{}'",
                    localization));
  }
  Autonomy autonomy;
  autonomy.localization = localization;
  autonomy.navigation = navigation;
  return autonomy;
}

}  // namespace threewe
