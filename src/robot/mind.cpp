#include "threewe/robot/mind.hpp"

#include <string>
#include <vector>

#include "core/names.hpp"
#include "robot/truth_localizer.hpp"
#include "threewe/core/errors.hpp"

namespace threewe {

Mind mind_with(std::string_view localization) {
  const std::vector<std::string> names = {"slam", "truth"};
  Mind mind;
  if (localization == names[0]) return mind;
  if (localization != names[1]) throw ConfigError(unknown_name("localization", localization, names));
  mind.localizer = make_truth_localizer;
  mind.localization = localization;
  return mind;
}

}  // namespace threewe
