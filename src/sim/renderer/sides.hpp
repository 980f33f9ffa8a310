// The upright faces of solids.
#pragma once

#include <array>

#include "sim/renderer/materials.hpp"

namespace threewe::sim::view {

/// An upright face as a viewer in front of it sees it. The colour of its look is left open.
struct Side {
  Vec2 corner;  // the first, counter-clockwise
  Vec2 axis;    // from there along the face
  Vec2 normal;
  double length = 0.0;  // [m]
  SurfaceMaterial look;
};
/// Those of a box; of a disc only the first look means something: that of a face in full light.
using Sides = std::array<Side, 4>;

Sides make_sides(const VisibleSolid& solid, bool is_open);
/// A disc's at a point of it.
Side round_side(const VisibleSolid& disc, const SurfaceMaterial& look, Vec2 point);
/// How far around a disc a normal is, about [m]: the way around a square on its corner, as long as that around the
/// disc.
double along_round(double radius, Vec2 normal);
/// A side of a wall that is no longer than this is its end [m].
inline constexpr double kWallEnd = 0.45;

}  // namespace threewe::sim::view
