#include "nav/mover.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include <fmt/format.h>

namespace threewe::nav {
namespace {

template <typename Visit>
void visit_near(const map::OccupancyGrid& grid, Vec2 place, double reach, Visit visit) {
  const map::Cell low = grid.cell(place - Vec2{reach, reach});
  const map::Cell high = grid.cell(place + Vec2{reach, reach});
  for (int y = std::max(low.y, 0); y <= std::min(high.y, grid.height - 1); ++y) {
    for (int x = std::max(low.x, 0); x <= std::min(high.x, grid.width - 1); ++x) {
      if (distance(grid.center({x, y}), place) < reach) visit(map::Cell{x, y});
    }
  }
}

}  // namespace

std::vector<Vec2> free_cells_near(const map::OccupancyGrid& grid, Vec2 place, double reach) {
  std::vector<Vec2> free;
  visit_near(grid, place, reach, [&](map::Cell c) {
    const std::int8_t value = grid.data[grid.index(c)];
    if (value >= 0 && value <= map::OccupancyGrid::kFreeThreshold) free.push_back(grid.center(c));
  });
  return free;
}

void remember_free(Mover& mover, std::span<const Vec2> before) {
  const double reach = (1.0 + kFarthestGone) * mover.radius;
  std::vector<Vec2> both;
  std::ranges::set_union(mover.free_around, before, std::back_inserter(both),
                         [](Vec2 a, Vec2 b) { return a.y < b.y || (a.y == b.y && a.x < b.x); });
  std::erase_if(both, [&](Vec2 place) { return distance(place, mover.position) >= reach; });
  mover.free_around = std::move(both);
}

std::vector<Mover> gone_on(std::span<const Mover> movers, Time now, double speed) {
  std::vector<Mover> later(movers.begin(), movers.end());
  for (auto mover = later.rbegin(); mover != later.rend(); ++mover) {
    const auto is_it = [&](const Mover& newer) { return newer.name == mover->name; };
    if (mover->free_around.empty() || std::any_of(later.rbegin(), mover, is_it)) continue;
    mover->gone_on = std::min(speed * to_seconds(now - mover->seen), kFarthestGone * mover->radius);
  }
  return later;
}

const Mover* mover_near(Vec2 point, std::span<const Mover> movers, double reach) {
  const auto is_near = [&](const Mover& mover) {
    return distance(point, mover.position) < mover.radius + mover.gone_on + reach;
  };
  const auto found = std::find_if(movers.rbegin(), movers.rend(), is_near);
  return found == movers.rend() ? nullptr : &*found;
}

void erase_movers(map::OccupancyGrid& grid, std::span<const Mover> movers, double blur) {
  const auto free = [&](map::Cell c) { grid.data[grid.index(c)] = map::OccupancyGrid::kFree; };
  for (const Mover& mover : movers) {
    const double reach = mover.radius + mover.gone_on + blur;
    if (mover.free_around.empty()) visit_near(grid, mover.position, reach, free);
    for (const Vec2 place : mover.free_around) {
      const map::Cell c = grid.cell(place);
      if (grid.contains(c) && distance(place, mover.position) < reach) free(c);
    }
  }
}

std::string to_string(const Mover& mover) {
  return fmt::format("{} at ({:.2f}, {:.2f})", mover.name, mover.position.x, mover.position.y);
}

}  // namespace threewe::nav
