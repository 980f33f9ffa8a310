#include "slam/prior_map.hpp"

#include <numbers>

#include "core/exact.hpp"
#include "core/grid_line.hpp"

namespace threewe::slam {
PriorMap::PriorMap(const map::OccupancyGrid& grid, const SharedParams& params)
    : before_wall_(params->registration.before_wall),
      surfaces_(map::LogOddsMap::going_on_from(grid, params->mapping.free_range)),
      search_(grid, params->global_search) {
  grid_ = {grid.width, grid.height, grid.resolution, grid.origin, {}};
  cells_.assign(grid.data.size(), kUnknown);
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const std::int8_t evidence = surfaces_.log_odds({x, y});
      std::uint8_t& cell = cells_[grid_.index({x, y})];
      if (evidence < 0 && cell == kUnknown) cell = kFree;
      if (evidence <= 0) continue;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          if (!grid_.contains({x + dx, y + dy})) continue;
          std::uint8_t& near = cells_[grid_.index({x + dx, y + dy})];
          if (near != kOccupied) near = kNear;
        }
      }
      cell = kOccupied;
    }
  }
}

Resemblance PriorMap::compare(const Pose2D& map_from_base, std::span<const map::Beam> beams) const {
  Resemblance sum;
  const auto [s, c] = exact::sincos(map_from_base.theta);
  const auto in_map = [&, s = s, c = c](Vec2 p) {
    return map_from_base.position() + Vec2{c * p.x - s * p.y, s * p.x + c * p.y};
  };
  for (const map::Beam& beam : beams) {
    const Vec2 from = in_map(beam.origin);
    const Vec2 to = in_map(beam.origin + beam.range * beam.direction);
    if (beam.hit) {
      const std::uint8_t cell = at(grid_.cell(to));
      sum.hits += cell != kUnknown ? 1 : 0;
      sum.on_surface += cell >= kNear ? 1 : 0;
    }
    if (beam.range <= before_wall_ || at(grid_.cell(from)) == kUnknown) continue;
    ++sum.beams;
    const Vec2 before = in_map(beam.origin + (beam.range - before_wall_) * beam.direction);
    sum.through_walls += passes_wall(from, before) ? 1 : 0;
  }
  return sum;
}

bool PriorMap::passes_wall(Vec2 from, Vec2 to) const {
  const double cells = 1.0 / grid_.resolution;
  return !walk_grid_line(cells * (from - grid_.origin), cells * (to - grid_.origin),
                         [this](int x, int y) { return at({x, y}) != kOccupied; });
}

Vec2 PriorMap::spread() const {
  const double uniform = 0.5 * std::numbers::inv_sqrt3 * grid_.resolution;  // deviation of what is uniform
  return {uniform * grid_.width, uniform * grid_.height};
}

}  // namespace threewe::slam
