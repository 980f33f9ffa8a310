#include "threewe/robot/autonomy.hpp"

#include <string>
#include <vector>

#include "core/names.hpp"
#include "robot/truth_localizer.hpp"
#include "threewe/core/errors.hpp"

namespace threewe {

Autonomy autonomy_with(std::string_view localization) {
  const std::vector<std::string> names = {"slam", "truth"};
  Autonomy autonomy;
  if (localization == names[0]) return autonomy;
  if (localization != names[1]) throw ConfigError(unknown_name("localization", localization, names));
  autonomy.localizer = make_truth_localizer;
  autonomy.localization = localization;
  return autonomy;
}

}  // namespace threewe
