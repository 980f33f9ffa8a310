// Crossing point of a straight opening, such as a doorway.
#pragma once

#include <algorithm>

#include "threewe/core/pose.hpp"

namespace threewe {

/// Where an opening from `a` to `b` [m] is crossed by who comes straight from a point: 0.4 m from its ends where it is
/// wide enough, else in its middle.
inline Vec2 crossing_of(Vec2 a, Vec2 b, Vec2 from) {
  constexpr double kFromEnd = 0.4;  // [m]
  const double length = distance(a, b);
  const double inset = std::min(kFromEnd, 0.5 * length);
  const Vec2 along = length > 0.0 ? (1.0 / length) * (b - a) : Vec2{};
  return a + std::clamp(dot(from - a, along), inset, std::max(inset, length - inset)) * along;
}

}  // namespace threewe
