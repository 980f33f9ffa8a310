// What a renderer knows about its scene before it draws: solids, rooms, shade on the floor, and how faces look.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "threewe/sim/renderer.hpp"

namespace threewe::sim::view {

/// The faces of a solid: sides 0 to 3 of a box (edge i begins at corner i), one of a disc, top and bottom.
inline constexpr int kTopFace = 4;
inline constexpr int kBottomFace = 5;
inline constexpr int kRoundFace = 6;

/// How a face takes colour from its texture: colour * (dark + contrast * brightness) * min(1, shade + shade_rise * v),
/// where brightness is 0 to 255 and v is in tiles.
struct Look {
  Material material{};
  Colour colour;
  float dark = 1.0F;
  float contrast = 0.0F;
  float shade = 1.0F;
  float shade_rise = 0.0F;
};

/// How light the floor is, on a grid. Cells hold four bytes: light at their own corner and at those at +x, +y, +x +y.
struct FloorLight {
  static constexpr double kCell = 0.1;  // [m]
  Vec2 origin;
  int width = 1;
  int height = 1;
  std::vector<std::uint32_t> cells{~0U};

  /// 0 to 1 at a point, interpolated; beyond the grid as at its edge.
  double at(Vec2 point) const;
};

struct FloorRoom {
  Vec2 min;
  Vec2 max;
  Look floor;
  Colour wall;
};

/// Solids that stand together, as those of an object do, and a circle around them.
struct Group {
  std::size_t first = 0;
  std::size_t last = 0;
  Vec2 center;
  double radius = 0.0;
  bool is_full = false;  // one wall from floor to ceiling: hides all that is behind it
};

struct Place {
  std::vector<VisibleSolid> solids;
  std::vector<Group> groups;
  std::vector<int> palettes;  // of each solid: what `Paint` may choose from; -1 for walls
  std::vector<FloorRoom> rooms;
  Look outside_floor;
  Look ceiling_look;
  double ceiling = 0.0;
  FloorLight light;

  explicit Place(const scene::Scene& scene);
  /// The room that holds a point, or null.
  const FloorRoom* room_at(Vec2 point) const;
};

/// Height of the skirting along the walls [m].
inline constexpr double kSkirting = 0.08;
/// Clear height of a doorway below its lintel [m].
inline constexpr double kDoorHeight = 2.05;

Look make_look(Material material, Colour colour, float shade);
/// How bright a vertical face is that faces along `normal` (a unit vector of the scene's frame).
float side_shade(Vec2 normal);
/// How a face of a solid looks. A wall's colour is that of the room in front of it, at `front`; the ends of walls,
/// where doorways are, are trimmed.
Look side_look(const Place& place, const VisibleSolid& solid, Colour colour, int face, Vec2 normal, Vec2 front);
Look skirting_look(Vec2 normal);
Look top_look(const VisibleSolid& solid, Colour colour);
Look bottom_look(const VisibleSolid& solid, Colour colour);
/// The sky at a slope above the horizon, z / x of the ray.
Colour sky_colour(float slope);

/// A lintel over each doorway whose wall reaches higher.
std::vector<scene::Solid> lintels(const scene::Scene& scene);

}  // namespace threewe::sim::view
