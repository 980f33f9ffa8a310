#include "threewe/map/occupancy_grid.hpp"

#include <cmath>

namespace threewe::map {

Cell OccupancyGrid::cell(Vec2 point) const {
  return {static_cast<int>(std::floor((point.x - origin.x) / resolution)),
          static_cast<int>(std::floor((point.y - origin.y) / resolution))};
}

Vec2 OccupancyGrid::center(Cell c) const {
  return {origin.x + (c.x + 0.5) * resolution, origin.y + (c.y + 0.5) * resolution};
}

}  // namespace threewe::map
