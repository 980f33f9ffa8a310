#include "nav/frontier_worth.hpp"

#include <algorithm>
#include <limits>

#include "nav/grid_search.hpp"

namespace threewe::nav {
namespace {

using map::Cell;

// The cells of a frontier, which are 8-connected; `taken` marks those of all that were asked for.
std::vector<Cell> cells_of(const map::Costmap& costmap, Cell frontier, const std::vector<std::uint16_t>& size_of,
                           std::vector<std::uint8_t>& taken) {
  std::vector<Cell> cells = {frontier};
  taken[costmap.index(frontier)] = 1;
  for (std::size_t next = 0; next < cells.size(); ++next) {
    for (const Cell d : kDirections) {
      const Cell c{cells[next].x + d.x, cells[next].y + d.y};
      if (!costmap.contains(c) || size_of[costmap.index(c)] == 0 || taken[costmap.index(c)]) continue;
      taken[costmap.index(c)] = 1;
      cells.push_back(c);
    }
  }
  return cells;
}

// Cells of unknown floor behind a frontier, `most` of them at most, which no wall that was seen separates from it.
std::size_t unknown_behind(const map::Costmap& costmap, const std::vector<Cell>& frontier, std::size_t most) {
  std::vector<std::uint8_t> taken(costmap.weights().size(), 0);
  std::vector<Cell> floor;
  const auto take_around = [&](Cell at) {
    for (std::size_t d = 0; d < 4; ++d) {
      const Cell c{at.x + kDirections[d].x, at.y + kDirections[d].y};
      if (!costmap.contains(c)) continue;
      const std::size_t i = costmap.index(c);
      if (taken[i] || !costmap.unknown()[i] || costmap.weights()[i] == map::Costmap::kLethal) continue;
      taken[i] = 1;
      floor.push_back(c);
    }
  };
  for (const Cell cell : frontier) take_around(cell);
  for (std::size_t next = 0; next < floor.size() && floor.size() < most; ++next) take_around(floor[next]);
  return std::min(floor.size(), most);
}

bool is_worthwhile(const map::Costmap& costmap, const Params::Frontier& params, const std::vector<Cell>& frontier,
                   double way) {
  const double cell = costmap.resolution();
  const double length = cell * static_cast<double>(frontier.size());
  const double wanted = params.strip * way;
  if (params.view * length * length < wanted) return false;
  const auto most = static_cast<std::size_t>(wanted / (cell * cell)) + 1;
  return unknown_behind(costmap, frontier, most) == most;
}

}  // namespace

bool is_worthwhile(const map::Costmap& costmap, const Params::Frontier& params, Cell frontier,
                   const std::vector<std::uint16_t>& size_of, double way) {
  std::vector<std::uint8_t> taken(size_of.size(), 0);
  return is_worthwhile(costmap, params, cells_of(costmap, frontier, size_of, taken), way);
}

void drop_frontier(const map::Costmap& costmap, Cell frontier, std::vector<std::uint16_t>& size_of) {
  std::vector<std::uint8_t> taken(size_of.size(), 0);
  for (const Cell cell : cells_of(costmap, frontier, size_of, taken)) size_of[costmap.index(cell)] = 0;
}

bool drop_far_frontiers(const map::Costmap& costmap, const Params::Frontier& params, Vec2 robot,
                        std::vector<std::uint16_t>& size_of) {
  bool dropped = false;
  std::vector<std::uint8_t> taken(size_of.size(), 0);
  for (int y = 0; y < costmap.height(); ++y) {
    for (int x = 0; x < costmap.width(); ++x) {
      const std::size_t i = costmap.index({x, y});
      if (size_of[i] == 0 || taken[i]) continue;
      const std::vector<Cell> cells = cells_of(costmap, {x, y}, size_of, taken);
      double nearest = std::numeric_limits<double>::infinity();
      for (const Cell cell : cells) nearest = std::min(nearest, distance(costmap.center(cell), robot));
      if (is_worthwhile(costmap, params, cells, nearest)) continue;
      for (const Cell cell : cells) size_of[costmap.index(cell)] = 0;
      dropped = true;
    }
  }
  return dropped;
}

}  // namespace threewe::nav
