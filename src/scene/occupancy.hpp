// Exact occupancy: which cells of a grid solids reach into, and how far cells are from them.
#pragma once

#include <span>

#include "scene/obstacles.hpp"
#include "threewe/scene/cell_grid.hpp"
#include "threewe/scene/scene.hpp"

namespace threewe::scene {

inline constexpr double kCellSize = 0.05;  ///< [m]

/// A frame of 5 cm cells over a scene and a margin of two cells, with cell corners at whole multiples of 5 cm.
GridFrame grid_over(const Scene& scene);
/// The cells whose square overlaps a solid, those inside it included.
CellSet occupied_cells(const GridFrame& frame, std::span<const Solid> solids);
/// The exact distance [m] from every cell's centre to the centre of the nearest cell in the set; infinity when the set
/// is empty (Felzenszwalb & Huttenlocher 2012).
CellGrid<float> distance_field(const CellSet& set);
/// The cells whose centre is at least `radius` [m] away from all obstacles, exactly.
CellSet cells_with_clearance(const Obstacles& obstacles, const CellGrid<float>& distance_to_occupied, double radius);
/// The cells of `set` that are connected with the one at `seed`, by sides. Empty when that one isn't in the set.
CellSet connected_cells(const CellSet& set, Vec2 seed);

}  // namespace threewe::scene
