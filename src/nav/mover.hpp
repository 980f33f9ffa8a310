// Moving obstacles that may have stopped in the way.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"
#include "threewe/map/occupancy_grid.hpp"

namespace threewe::nav {

/// Something that moves by itself, where it was last seen to move, in `map`.
struct Mover {
  std::string name;     ///< what results call it
  Vec2 position;        ///< [m]
  double radius = 0.0;  ///< [m] of a disc around it
  Time seen{};          ///< there
  /// [m] Middles of the cells around it that were free as it came; it covers no others. Empty: whatever its disc does.
  std::vector<Vec2> free_around = {};
  double gone_on = 0.0;  ///< [m] beyond its disc, so far at most
};

/// Of a disc, how many times its radius [m] what was seen there may have gone on unnoticed.
inline constexpr double kFarthestGone = 2.0;
/// Middles [m] of the free cells around a place, by y, then by x.
std::vector<Vec2> free_cells_near(const map::OccupancyGrid& grid, Vec2 place, double reach);
/// Where it was free as it came: around where it is now, or when it was elsewhere before.
void remember_free(Mover& mover, std::span<const Vec2> before);
/// The same now: what creeps is not seen to move, so that each may be elsewhere than where it was seen last, by `speed`
/// [m/s] since.
std::vector<Mover> gone_on(std::span<const Mover> movers, Time now, double speed);
/// The last of `movers` that a point is nearer to than `reach` [m] beyond its disc; null where there is none.
const Mover* mover_near(Vec2 point, std::span<const Mover> movers, double reach);
/// Frees the cells that movers, and hits that are off by `blur` [m], cover: these were free when they came there.
void erase_movers(map::OccupancyGrid& grid, std::span<const Mover> movers, double blur);
/// "robot 1 at (2.00, 0.50)".
std::string to_string(const Mover& mover);

}  // namespace threewe::nav
