// Map merged from several robots.
#pragma once

#include <span>

#include "threewe/map/occupancy_grid.hpp"
#include "threewe/nav/navigator.hpp"

namespace threewe::nav {

/// Our map, and where we know nothing what peers know, nearest first in their order. In our raster; as large as all of
/// them together, except for those that are too far away (map::fits_a_grid).
void merge_maps(const map::OccupancyGrid& ours, std::span<const Peer> peers, map::OccupancyGrid& merged);

}  // namespace threewe::nav
