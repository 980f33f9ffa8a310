// Worth of a frontier: how long a way is worth what can be seen from there.
#pragma once

#include <cstdint>
#include <vector>

#include "map/costmap.hpp"
#include "nav/params.hpp"

namespace threewe::nav {

/// Whether a frontier is worth a way of that length [m]. Behind it lies as much unknown floor as can be reached through
/// unknown space where a robot could stand; through a narrow opening little of that is seen, so that no more counts
/// than `view` times the square of the frontier's length. All of it, spread along the way, must be a strip as wide as
/// `strip`. So a doorway to a room that was never seen is worth the way through a building, a corner behind a cupboard
/// is worth a few metres.
bool is_worthwhile(const map::Costmap& costmap, const Params::Frontier& params, map::Cell frontier,
                   const std::vector<std::uint16_t>& size_of, double way);

/// Takes away the frontier that a cell belongs to.
void drop_frontier(const map::Costmap& costmap, map::Cell frontier, std::vector<std::uint16_t>& size_of);

/// Takes away the frontiers that are not even worth the straight way from `robot` [m]. True where there were some.
bool drop_far_frontiers(const map::Costmap& costmap, const Params::Frontier& params, Vec2 robot,
                        std::vector<std::uint16_t>& size_of);

}  // namespace threewe::nav
