#include "nav/tile_walk.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>

#include "nav/tile_field.hpp"

namespace threewe::nav {
namespace {

using map::Cell;

bool is_inside(Cell c) { return c.x >= 0 && c.y >= 0 && c.x < kernel::kSide && c.y < kernel::kSide; }
std::size_t place_of(Cell c) { return static_cast<std::size_t>(kernel::place(c.x, c.y)); }

class Walk {
 public:
  Walk(const map::Costmap& costmap, const TileWay& way, Cell start)
      : costmap_(costmap), way_(way), start_(start), costs_(way.tiles.size()), least_(way.tiles.size()) {}

  // Costs spread tile by tile, from the start and then from each shared line.
  void spread() {
    for (std::size_t t = 0; t < way_.tiles.size(); ++t) {
      load_steps(costmap_, way_.tiles[t], start_, *steps_);
      costs_[t].at.fill(kernel::kUnreached);
      if (t == 0) {
        costs_[t].at[place_of(inside(t, start_))] = 0;
      } else {
        enter(t);
      }
      kernel::spread(*steps_, costs_[t]);
    }
  }

  // Back from the goal, always to where the costs came from.
  std::vector<Cell> trace(Cell goal) {
    std::vector<Cell> path = {goal};
    for (std::size_t t = way_.tiles.size(); t-- > 0;) {
      load_steps(costmap_, way_.tiles[t], start_, *steps_);
      while (t == 0 ? path.back() != start_ : !is_entrance(t, path.back())) path.push_back(before(t, path.back()));
    }
    std::reverse(path.begin(), path.end());
    return path;
  }

 private:
  Cell inside(std::size_t t, Cell c) const { return {c.x - way_.tiles[t].x, c.y - way_.tiles[t].y}; }

  // Takes over the costs on the line that a tile shares with the one before.
  void enter(std::size_t t) {
    const Cell shift{way_.tiles[t].x - way_.tiles[t - 1].x, way_.tiles[t].y - way_.tiles[t - 1].y};
    const kernel::Costs& last = costs_[t - 1];
    std::int32_t least = kernel::kUnreached;
    const auto for_each_shared = [&](auto visit) {
      for (int y = std::max(0, -shift.y); y < kernel::kSide + std::min(0, -shift.y); ++y) {
        for (int x = std::max(0, -shift.x); x < kernel::kSide + std::min(0, -shift.x); ++x) {
          visit(place_of({x, y}), last.at[place_of({x + shift.x, y + shift.y})]);
        }
      }
    };
    for_each_shared([&](std::size_t, std::int32_t cost) { least = std::min(least, cost); });
    for_each_shared([&](std::size_t place, std::int32_t cost) {
      if (cost < kernel::kUnreached) costs_[t].at[place] = cost - least;
    });
    least_[t] = least;
  }

  // Whether the cheapest path to this cell comes from the tile before.
  bool is_entrance(std::size_t t, Cell c) const {
    const Cell there = inside(t - 1, c);
    return is_inside(there) && costs_[t - 1].at[place_of(there)] - least_[t] == costs_[t].at[place_of(inside(t, c))];
  }

  Cell before(std::size_t t, Cell c) const {
    const auto here = static_cast<int>(place_of(inside(t, c)));
    const auto& costs = costs_[t].at;
    for (std::size_t i = 0; i < kernel::Steps::kCount; ++i) {
      for (const int sign : {1, -1}) {
        const int there = here + sign * kernel::Steps::kOffsets[i];
        const std::int32_t step = steps_->cost[i][static_cast<std::size_t>(sign > 0 ? here : there)];
        if (costs[static_cast<std::size_t>(there)] + step != costs[static_cast<std::size_t>(here)]) continue;
        return {way_.tiles[t].x + there % kernel::kRow - kernel::kRim,
                way_.tiles[t].y + there / kernel::kRow - kernel::kRim};
      }
    }
    return c;
  }

  const map::Costmap& costmap_;
  const TileWay& way_;
  Cell start_;
  std::vector<kernel::Costs> costs_;  // in each tile, above the least with which it is entered
  std::vector<std::int32_t> least_;   // and that, above the least of the tile before
  std::unique_ptr<kernel::Steps> steps_ = std::make_unique_for_overwrite<kernel::Steps>();
};

}  // namespace

std::vector<Cell> walk_tiles(const map::Costmap& costmap, const TileWay& way, Cell start, Cell goal) {
  Walk walk(costmap, way, start);
  walk.spread();
  return walk.trace(goal);
}

}  // namespace threewe::nav
