// Frontier detection: where the known free space ends.
#pragma once

#include <cstdint>
#include <vector>

#include "map/costmap.hpp"

namespace threewe::nav {

/// For each cell of `costmap` the size of the frontier it belongs to, 0 for none. A frontier is an 8-connected group of
/// cells that a robot can stand on, known to be free, each next to (4-connected) a gap. A gap is an unknown cell of
/// whose 5 x 5 neighbourhood at least `kGapCells` are unknown, so that the slits between beams are none.
inline constexpr int kGapCells = 12;
void find_frontiers(const map::Costmap& costmap, std::vector<std::uint16_t>& size_of);

}  // namespace threewe::nav
