// A path through tiles, cell by cell.
#pragma once

#include <vector>

#include "nav/tile_graph.hpp"

namespace threewe::nav {

/// The cheapest path that visits these tiles one after the other, by steps to 16 neighbours. Called by `Planner`.
std::vector<map::Cell> walk_tiles(const map::Costmap& costmap, const TileWay& way, map::Cell start, map::Cell goal);

}  // namespace threewe::nav
