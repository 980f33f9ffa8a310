// Filtered hits of a lidar: range noise averaged out along surfaces.
#pragma once

#include <span>
#include <vector>

#include "threewe/core/pose.hpp"

namespace threewe::map {

/// [m] around a hit of the reference robot, surfaces are flat.
inline constexpr double kNeighbourhood = 0.08;

/// Each hit [m], seen from `lidar`, moved along its ray onto the line that its neighbours in the neighbourhood lie on,
/// where a flat surface scatters half as much. Of the neighbourhoods all around and to each of its sides the
/// straightest counts, so that corners stay (Kuwahara et al. 1976, for pictures). A hit with too few neighbours, or
/// none in a line, stays where it is. Takes time as hits squared: meant for those near the robot.
std::vector<Vec2> smoothed(std::span<const Vec2> hits, Vec2 lidar, double neighbourhood = kNeighbourhood);
/// Those less than `reach` [m] from a point, and nothing else taken into account.
std::vector<Vec2> smoothed_near(Vec2 point, double reach, std::span<const Vec2> hits, Vec2 lidar,
                                double neighbourhood = kNeighbourhood);

}  // namespace threewe::map
