// Renderer's precomputed scene: solids, floors, and the light on them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/renderer.hpp"
#include "sim/renderer/intersect.hpp"
#include "sim/renderer/light.hpp"
#include "sim/renderer/materials.hpp"
#include "sim/renderer/sides.hpp"
#include "sim/renderer/walls.hpp"

namespace threewe::sim::view {

/// A rectangle of floor: a patch or a room.
struct FloorRegion {
  Vec2 min;
  Vec2 max;
  SurfaceMaterial floor;
  Colour wall;                     ///< of a room
  std::vector<std::size_t> above;  ///< those that lie on it
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
  std::vector<VisibleSolid> solids;  // walls first, in the scene's order
  std::vector<Sides> sides;          // theirs
  std::vector<Group> groups;
  Circles circles;                  // around them
  std::vector<int> palettes;        // of each solid: what `Shading` may choose from; -1 for walls
  std::vector<FloorRegion> floors;  // what lies on top comes first
  std::size_t patch_count = 0;      // of those, before the rooms
  SurfaceMaterial outside_floor;
  bool is_open = false;  // under the sky
  double ceiling = 0.0;
  SurfaceMaterial ceiling_material;
  WallDecor decor;
  FloorLight light;
  FloorLight corner_light;  // with nothing but walls

  explicit Place(const scene::Scene& scene);
  /// The patch or room that holds a point, or null.
  const FloorRegion* floor_at(Vec2 point) const;
  /// The room that holds a point, or null.
  const FloorRegion* room_at(Vec2 point) const;
  /// What is on the faces of a solid, if it is a wall; -1 stands for one that moves.
  std::span<const Decor> decor_of(int solid) const;
  /// The colour of a solid in an episode; none for a wall, whose colour depends on the room before it.
  Colour colour(const Shading& shading, std::size_t solid) const;
  bool has_skirting(const VisibleSolid& solid) const {
    return solid.id == kWallId && solid.solid.z_min <= 0.0 && !is_open;
  }
  /// What all walls are painted in, before light, where a picture has no detail.
  Colour plain_wall() const { return is_open ? kBrick : view::wall_colour(0); }
  /// The tints along a side of a wall of the scene, one every `kTintStep`: the paint of the room in front of it in its
  /// light; the ends of walls, where doorways are, are trimmed.
  std::span<const std::uint32_t> tints_of(std::size_t wall, std::size_t face) const;

 private:
  std::vector<std::uint32_t> wall_tints_;
  std::vector<std::size_t> first_tint_;  // by wall and face, and one more

  void shade_walls();
  Colour wall_colour(const VisibleSolid& wall, const Side& side, Vec2 point) const;
  float wall_colour(Vec2 normal, Vec2 point) const;

  void add_solids(const scene::Scene& scene);
  const FloorRegion* find_floor(std::size_t first, Vec2 point) const;
};

/// Blue, green and red in the low bytes of a word, at most 255 each.
std::uint32_t pack(const Colour& colour);

/// From one tint of a wall to the next [m].
inline constexpr double kTintStep = 1.0 / 64.0;
/// Height of the skirting along the walls [m], and of a picture's detail from which on it is seen.
inline constexpr double kSkirting = 0.08;
inline constexpr float kSkirtingDetail = 0.5F;

}  // namespace threewe::sim::view
