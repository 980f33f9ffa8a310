#include "sim/renderer/sides.hpp"

#include <cmath>

#include "core/exact.hpp"

namespace threewe::sim::view {

using scene::Solid;

Sides make_sides(const VisibleSolid& visible, bool is_open) {
  Sides sides;
  const Solid& solid = visible.solid;
  if (solid.shape == Solid::Shape::disc) {
    sides[0].look = side_material(visible, visible.material, 1.0F);
    return sides;
  }
  for (std::size_t i = 0; i < sides.size(); ++i) {
    Side& side = sides[i];
    side.corner = solid.corners[i];
    const Vec2 edge = solid.corners[(i + 1) % 4] - side.corner;
    side.length = norm(edge);
    side.axis = (1.0 / side.length) * edge;
    side.normal = {side.axis.y, -side.axis.x};
    const bool is_trimmed = visible.id == kWallId && !is_open && side.length < kWallEnd;
    side.look = side_material(visible, is_trimmed ? Material::trim : visible.material, side_shade(side.normal));
  }
  return sides;
}

Side round_side(const VisibleSolid& disc, const SurfaceMaterial& look, Vec2 point) {
  Side side;
  side.normal = (1.0 / disc.solid.radius) * (point - disc.solid.center);
  side.look = look;
  side.look.light *= side_shade(side.normal);
  return side;
}

double along_round(double radius, Vec2 normal) {
  const double ahead = normal.y / (std::fabs(normal.x) + std::fabs(normal.y));
  const double quarters = normal.x >= 0.0 ? ahead : (normal.y >= 0.0 ? 2.0 : -2.0) - ahead;
  return 0.5 * exact::kPi * radius * quarters;
}

}  // namespace threewe::sim::view
