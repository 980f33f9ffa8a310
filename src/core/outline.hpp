// The outline of a polygon.
#pragma once

#include <cstddef>
#include <limits>
#include <span>

#include "threewe/core/pose.hpp"

namespace threewe {

/// The point on the outline of a closed polygon that is nearest to `point`; of several the first.
inline Vec2 closest_on_outline(Vec2 point, std::span<const Vec2> corners) {
  Vec2 closest;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2 candidate = closest_on_segment(point, corners[i], corners[i + 1 == corners.size() ? 0 : i + 1]);
    const Vec2 offset = point - candidate;
    if (dot(offset, offset) >= least) continue;
    least = dot(offset, offset);
    closest = candidate;
  }
  return closest;
}

}  // namespace threewe
