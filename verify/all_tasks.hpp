// The tasks of the learning environments.
#pragma once

#include <vector>

#include "threewe/env/batch.hpp"
#include "threewe/task/exploration.hpp"
#include "threewe/task/navigation.hpp"
#include "threewe/task/object_nav.hpp"
#include "threewe/task/vln.hpp"

inline std::vector<threewe::env::TaskFactory> all_tasks() {
  using threewe::task::Setting;
  return {[](const Setting& setting) { return threewe::task::make_navigation(setting, {.goals = 4}); },
          [](const Setting& setting) { return threewe::task::make_exploration(setting); },
          threewe::task::make_object_nav, threewe::task::make_vln};
}
