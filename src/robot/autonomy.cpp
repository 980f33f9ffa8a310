#include "threewe/robot/world.hpp"

#include <algorithm>
#include <vector>

#include "core/names.hpp"
#include "threewe/core/errors.hpp"

namespace threewe {

Autonomy autonomy_with(std::string_view localization) {
  const std::vector<std::string> names = {"slam", "truth"};
  if (std::ranges::find(names, localization) == names.end()) {
    throw ConfigError(unknown_name("localization", localization, names));
  }
  Autonomy autonomy;
  autonomy.localization = localization;
  return autonomy;
}

}  // namespace threewe
