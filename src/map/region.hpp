// Region of a map: a rectangle of cells.
#pragma once

#include "threewe/map/occupancy_grid.hpp"

namespace threewe::map {

/// From `low` up to, but without, `high`.
struct Region {
  Cell low;
  Cell high;
  bool empty() const { return low.x >= high.x || low.y >= high.y; }
  friend bool operator==(const Region&, const Region&) = default;
};

}  // namespace threewe::map
