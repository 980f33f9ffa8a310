#include "nav/mover.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace threewe::nav {

const Mover* mover_near(Vec2 point, std::span<const Mover> movers, double reach) {
  const auto is_near = [&](const Mover& mover) { return distance(point, mover.position) < mover.radius + reach; };
  const auto found = std::find_if(movers.rbegin(), movers.rend(), is_near);
  return found == movers.rend() ? nullptr : &*found;
}

void erase_movers(map::OccupancyGrid& grid, std::span<const Mover> movers, double blur) {
  for (const Mover& mover : movers) {
    const double reach = mover.radius + blur;
    const map::Cell low = grid.cell(mover.position - Vec2{reach, reach});
    const map::Cell high = grid.cell(mover.position + Vec2{reach, reach});
    for (int y = std::max(low.y, 0); y <= std::min(high.y, grid.height - 1); ++y) {
      for (int x = std::max(low.x, 0); x <= std::min(high.x, grid.width - 1); ++x) {
        if (distance(grid.center({x, y}), mover.position) < reach)
          grid.data[grid.index({x, y})] = map::OccupancyGrid::kFree;
      }
    }
  }
}

std::string to_string(const Mover& mover) {
  return fmt::format("{} at ({:.2f}, {:.2f})", mover.name, mover.position.x, mover.position.y);
}

}  // namespace threewe::nav
