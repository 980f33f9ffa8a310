// Moving obstacles that may have stopped in the way.
#pragma once

#include <span>
#include <string>

#include "threewe/core/pose.hpp"
#include "threewe/map/occupancy_grid.hpp"

namespace threewe::nav {

/// Something that moves by itself, where it was last seen to move, in `map`.
struct Mover {
  std::string name;     ///< what results call it
  Vec2 position;        ///< [m]
  double radius = 0.0;  ///< [m] of a disc around it
};

/// The last of `movers` that a point is nearer to than `reach` [m] beyond its disc; null where there is none.
const Mover* mover_near(Vec2 point, std::span<const Mover> movers, double reach);
/// Frees the cells that movers, and hits that are off by `blur` [m], cover: these were free when they came there.
void erase_movers(map::OccupancyGrid& grid, std::span<const Mover> movers, double blur);
/// "robot 1 at (2.00, 0.50)".
std::string to_string(const Mover& mover);

}  // namespace threewe::nav
