// Blind-zone obstacles: what is nearer to a lidar than it can measure, inferred from what stands on both sides.
#pragma once

#include <span>
#include <vector>

#include "threewe/core/pose.hpp"

namespace threewe::map {

/// A lidar sees nothing nearer than `range_min` [m], so that a wall at its side has a hole. Where two hits that are
/// neighbours by bearing lie at the rim of that blind disc and the straight line between them runs within it, the
/// surface goes on between them: points on that line, and nothing else. Hits and lidar are in one frame.
std::vector<Vec2> blind_surface(std::span<const Vec2> hits, Vec2 lidar, double range_min);

}  // namespace threewe::map
