// Frontier detection: where the known free space ends.
#pragma once

#include <cstdint>
#include <vector>

#include "map/costmap.hpp"
#include "nav/params.hpp"

namespace threewe::nav {

/// For each cell of `costmap` the size of the frontier it belongs to, 0 for none. A frontier is an 8-connected group of
/// cells that a robot can stand on, known to be free, each next to (4-connected) a gap. A gap is an unknown cell of
/// whose neighbourhood within `slit` to all sides half is unknown, so that the slits between
/// beams are none.
void find_frontiers(const map::Costmap& costmap, const Params::Frontier& params, std::vector<std::uint16_t>& size_of);

}  // namespace threewe::nav
