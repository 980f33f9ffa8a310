// Costs within one tile of a costmap.
#pragma once

#include "map/costmap.hpp"
#include "nav/tile_kernel.hpp"

namespace threewe::nav {

/// Takes the weights of the tile whose lower left cell is `corner`, and what steps cost in it. `start` can be left
/// whatever its weight, at kStartWeight at most; outside of the costmap are walls.
inline constexpr std::int32_t kStartWeight = 100;
void load_steps(const map::Costmap& costmap, map::Cell corner, map::Cell start, kernel::Steps& steps);

}  // namespace threewe::nav
