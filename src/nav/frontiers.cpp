#include "threewe/nav/frontiers.hpp"

#include <algorithm>

#include "threewe/nav/grid_search.hpp"

namespace threewe::nav {

void find_frontiers(const map::Costmap& costmap, std::vector<std::uint16_t>& size_of) {
  using map::Cell;
  constexpr std::uint16_t kCandidate = 0xFFFF;
  const auto gap = [&costmap](Cell c) {
    if (!costmap.unknown(c)) return false;
    int unknown = 0;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) unknown += costmap.unknown({c.x + dx, c.y + dy}) ? 1 : 0;
    }
    return unknown >= kGapCells;
  };

  // candidates first
  size_of.assign(costmap.weights().size(), 0);
  for (int y = 0; y < costmap.height(); ++y) {
    for (int x = 0; x < costmap.width(); ++x) {
      const Cell c{x, y};
      if (costmap.unknown(c) || costmap.weight(c) == map::Costmap::kLethal) continue;
      for (std::size_t i = 0; i < 4; ++i) {
        if (!gap({x + kDirections[i].x, y + kDirections[i].y})) continue;
        size_of[costmap.index(c)] = kCandidate;
        break;
      }
    }
  }

  // then what hangs together
  std::vector<Cell> group;
  for (int y = 0; y < costmap.height(); ++y) {
    for (int x = 0; x < costmap.width(); ++x) {
      if (size_of[costmap.index({x, y})] != kCandidate) continue;
      group.assign(1, {x, y});
      size_of[costmap.index({x, y})] = 1;
      for (std::size_t next = 0; next < group.size(); ++next) {
        for (const Cell d : kDirections) {
          const Cell c{group[next].x + d.x, group[next].y + d.y};
          if (!costmap.contains(c) || size_of[costmap.index(c)] != kCandidate) continue;
          size_of[costmap.index(c)] = 1;
          group.push_back(c);
        }
      }
      const auto size = static_cast<std::uint16_t>(std::min<std::size_t>(group.size(), kCandidate - 1));
      for (const Cell c : group) size_of[costmap.index(c)] = size;
    }
  }
}

}  // namespace threewe::nav
