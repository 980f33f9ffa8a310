// The tasks of the learning environments.
#pragma once

#include <vector>

#include "task/object_nav.hpp"
#include "task/vln.hpp"
#include "threewe/env/batch.hpp"
#include "threewe/task/tasks.hpp"

inline std::vector<threewe::env::TaskFactory> all_tasks() {
  using threewe::task::Setting;
  return {[](const Setting& setting) { return threewe::task::make_navigation(setting, {.goals = 4}); },
          [](const Setting& setting) { return threewe::task::make_exploration(setting); },
          threewe::task::make_object_nav, threewe::task::make_vln};
}
