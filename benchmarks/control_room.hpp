// What controllers are to drive through: a room with a table, and a door at its end.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/exact.hpp"
#include "threewe/core/pose.hpp"

namespace threewe {

/// What a lidar with 360 beams sees in a room of 6 m x 4 m with a table's legs and a door's jambs before it.
inline std::vector<Vec2> scan_of_a_room(double shift) {
  std::vector<Vec2> points;
  for (int i = 0; i < 360; ++i) {
    const auto [s, c] = exact::sincos(i * exact::kPi / 180.0);
    const double range = std::min(3.0 / std::max(std::fabs(c), 1e-9), 2.0 / std::max(std::fabs(s), 1e-9));
    points.push_back({(range + shift) * c, (range + shift) * s});
  }
  for (const Vec2 leg : {Vec2{0.6, 0.35}, {0.6, -0.4}, {1.2, 0.35}, {1.2, -0.4}}) points.push_back(leg);
  for (int i = 0; i < 40; ++i)
    points.push_back({1.5 + shift, 0.2 + 0.01 * i}), points.push_back({1.5, -0.2 - 0.01 * i});
  return points;
}

/// Between the legs, through the door and to the left.
inline const std::vector<Vec2> kPathThroughADoor = {{0.0, 0.0}, {1.0, 0.0}, {1.6, 0.05}, {2.5, 1.0}};

}  // namespace threewe
