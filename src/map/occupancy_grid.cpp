#include "threewe/map/occupancy_grid.hpp"

namespace threewe::map {

Cell OccupancyGrid::cell(Vec2 point) const {
  return {to_cell((point.x - origin.x) / resolution), to_cell((point.y - origin.y) / resolution)};
}

Vec2 OccupancyGrid::center(Cell c) const {
  return {origin.x + (c.x + 0.5) * resolution, origin.y + (c.y + 0.5) * resolution};
}

}  // namespace threewe::map
