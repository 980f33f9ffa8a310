#include "nav/frontiers.hpp"

#include <algorithm>
#include <cstddef>

#include "nav/grid_search.hpp"

namespace threewe::nav {
namespace {

// Whether half of the cells around an unknown one are so too. `kAround`: the reach, where the compiler is to know it.
template <int kAround>
bool is_gap(const std::uint8_t* middle, int width, int around) {
  const int reach = kAround > 0 ? kAround : around;
  const int side = 2 * reach + 1;
  int count = 0;
  for (int dy = -reach; dy <= reach; ++dy) {
    const std::uint8_t* row = middle + std::ptrdiff_t{dy} * width;
    for (int dx = -reach; dx <= reach; ++dx) count += row[dx];
  }
  return count >= side * side / 2;
}

}  // namespace

void find_frontiers(const map::Costmap& costmap, const Params::Frontier& params, std::vector<std::uint16_t>& size_of) {
  using map::Cell;
  constexpr std::uint16_t kCandidate = 0xFFFF;
  const std::vector<std::uint8_t>& unknown = costmap.unknown();
  const int around = std::max(1, cells_in(params.slit, costmap.resolution()));
  const auto gap = [&](int x, int y) {
    const std::uint8_t* middle = &unknown[costmap.index({x, y})];
    return around == 2 ? is_gap<2>(middle, costmap.width(), 2) : is_gap<0>(middle, costmap.width(), around);
  };

  // candidates first; the rim of a costmap is unknown, so that no frontier lies near its edge
  const int edge = around + 1;
  size_of.assign(costmap.weights().size(), 0);
  for (int y = edge; y < costmap.height() - edge; ++y) {
    for (int x = edge; x < costmap.width() - edge; ++x) {
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
  for (int y = edge; y < costmap.height() - edge; ++y) {
    for (int x = edge; x < costmap.width() - edge; ++x) {
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
