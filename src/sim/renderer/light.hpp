// The light on the floor, known before anything is drawn.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/renderer.hpp"

namespace threewe::sim::view {

/// How light the floor is, on a grid. Cells hold four bytes: light at their own corner and those at +x, +y, +x +y.
struct FloorLight {
  static constexpr double kCell = 0.1;       // [m]
  static constexpr double kBrightest = 1.5;  // what byte 255 stands for
  Vec2 origin;
  int width = 1;
  int height = 1;
  int line_bits = 0;                              // cells of a line are 2^this from those of the next
  std::vector<std::uint32_t> cells{0xAAAAAAAAU};  // 1 everywhere

  std::size_t index(int x, int y) const {
    return (static_cast<std::size_t>(y) << static_cast<unsigned>(line_bits)) + static_cast<std::size_t>(x);
  }
  /// 1 on a floor with nothing near, interpolated; beyond the grid as at its edge.
  double at(Vec2 point) const;
};

/// Where the sun shines through a window: a convex, counter-clockwise polygon on the floor.
struct SunPatch {
  std::array<Vec2, 4> corners;
};

/// Where the sun stands: its direction on the map, and how high it is [m per m].
inline constexpr Vec2 kSunward{0.6, 0.8};
inline constexpr double kSunSlope = 1.1;

/// Light falls off towards what stands on the floor, or hangs low above it. Under the open sky things cast shadows.
FloorLight make_light(std::span<const VisibleSolid> solids, bool is_open, std::span<const SunPatch> sun);

}  // namespace threewe::sim::view
