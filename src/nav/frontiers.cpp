#include "nav/frontiers.hpp"

#include <algorithm>

#include "nav/grid_search.hpp"

namespace threewe::nav {

void find_frontiers(const map::Costmap& costmap, std::vector<std::uint16_t>& size_of) {
  using map::Cell;
  constexpr std::uint16_t kCandidate = 0xFFFF;
  const std::vector<std::uint8_t>& unknown = costmap.unknown();
  const auto gap = [&](int x, int y) {
    int count = 0;
    for (int v = y - 2; v <= y + 2; ++v) {
      const std::uint8_t* row = &unknown[costmap.index({x, v})];
      count += row[-2] + row[-1] + row[0] + row[1] + row[2];
    }
    return count >= kGapCells;
  };

  // candidates first; the rim of a costmap is unknown, so that no frontier lies near its edge
  constexpr int kEdge = 3;
  size_of.assign(costmap.weights().size(), 0);
  for (int y = kEdge; y < costmap.height() - kEdge; ++y) {
    for (int x = kEdge; x < costmap.width() - kEdge; ++x) {
      const std::size_t i = costmap.index({x, y});
      if (unknown[i] != 0 || costmap.weights()[i] == map::Costmap::kLethal) continue;
      for (std::size_t d = 0; d < 4; ++d) {
        const Cell c{x + kDirections[d].x, y + kDirections[d].y};
        if (unknown[costmap.index(c)] == 0 || !gap(c.x, c.y)) continue;
        size_of[i] = kCandidate;
        break;
      }
    }
  }

  // then what hangs together
  std::vector<Cell> group;
  for (int y = kEdge; y < costmap.height() - kEdge; ++y) {
    for (int x = kEdge; x < costmap.width() - kEdge; ++x) {
      if (size_of[costmap.index({x, y})] != kCandidate) continue;
      group.assign(1, {x, y});
      size_of[costmap.index({x, y})] = 1;
      for (std::size_t next = 0; next < group.size(); ++next) {
        for (const Cell d : kDirections) {
          const Cell c{group[next].x + d.x, group[next].y + d.y};
          if (size_of[costmap.index(c)] != kCandidate) continue;
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
