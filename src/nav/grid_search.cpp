#include "nav/grid_search.hpp"

#include <algorithm>

namespace threewe::nav {

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
