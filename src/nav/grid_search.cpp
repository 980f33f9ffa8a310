#include "threewe/nav/grid_search.hpp"

#include <algorithm>
#include <cstdlib>

namespace threewe::nav {

SearchResult GridSearch::to_cell(const map::Costmap& costmap, map::Cell start, map::Cell goal) {
  // octile distance at the least weight: a step to a neighbour never lowers it by more than the step costs
  const auto heuristic = [goal](map::Cell c) {
    const auto dx = static_cast<std::uint32_t>(std::abs(c.x - goal.x));
    const auto dy = static_cast<std::uint32_t>(std::abs(c.y - goal.y));
    return 2U * map::Costmap::kFree * (5U * std::max(dx, dy) + 2U * std::min(dx, dy));
  };
  if (!costmap.contains(goal)) return {};
  const auto target = static_cast<std::uint32_t>(costmap.index(goal));
  return search(
      costmap, start, heuristic, [target](std::uint32_t index) { return index == target; },
      [](std::uint32_t) { return false; });
}

std::vector<map::Cell> GridSearch::path_to(const map::Costmap& costmap, std::uint32_t index) const {
  const auto width = static_cast<std::uint32_t>(costmap.width());
  map::Cell c{static_cast<int>(index % width), static_cast<int>(index / width)};
  std::vector<map::Cell> path = {c};
  for (std::uint8_t d = arrived_by_[costmap.index(c)]; d < 8; d = arrived_by_[costmap.index(c)]) {
    c = {c.x - kDirections[d].x, c.y - kDirections[d].y};
    path.push_back(c);
  }
  std::reverse(path.begin(), path.end());
  return path;
}

}  // namespace threewe::nav
