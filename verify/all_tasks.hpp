// The tasks of the learning environments.
#pragma once

#include <vector>

#include "task/object_nav.hpp"
#include "task/vln.hpp"
#include "threewe/env/batch.hpp"
#include "threewe/task/tasks.hpp"

inline std::vector<threewe::env::TaskFactory> all_tasks() {
  using threewe::task::TaskContext;
  return {[](const TaskContext& context) { return threewe::task::make_navigation(context, {.goals = 4}); },
          [](const TaskContext& context) { return threewe::task::make_exploration(context); },
          [](const TaskContext& context) { return threewe::task::make_object_nav(context); }, threewe::task::make_vln};
}
