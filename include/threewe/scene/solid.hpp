// Convex solids with a height range, seen from above, and exact distance and overlap tests between them.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "threewe/core/pose.hpp"

namespace threewe::scene {

/// A rectangle or a disc in the scene's frame, from `z_min` to `z_max`.
struct Solid {
  /// A rectangle or a disc.
  enum class Shape : std::uint8_t { box, disc };
  Shape shape{};                ///< a rectangle or a disc
  std::array<Vec2, 4> corners;  ///< of a box, counter-clockwise
  Vec2 center;                  ///< [m]
  double radius = 0.0;          ///< [m] of the disc, or of the circle around the box
  double z_min = 0.0;           ///< [m]
  double z_max = 0.0;           ///< [m]
  int object = -1;              ///< index into `Scene::objects`, -1 for walls
  friend bool operator==(const Solid&, const Solid&) = default;
};

/// A rectangle `length` long in direction `theta` and `width` wide. Quarter turns are exact, so that furniture along a
/// wall is exactly parallel to it.
Solid make_box(const Pose2D& middle, double length, double width);
/// A disc of `radius` [m] about `center` [m].
Solid make_disc(Vec2 center, double radius);

/// The corners of the smallest rectangle along the scene's axes that holds a solid.
std::pair<Vec2, Vec2> bounds(const Solid& solid);
/// The same for all of them; turned inside out, from infinity to -infinity, where there are none.
std::pair<Vec2, Vec2> bounds(std::span<const Solid> solids);
/// Distance [m] from a point to a solid, 0 inside.
double distance_to(const Solid& solid, Vec2 point);
/// Distance [m] from a point to the nearest of them; infinity where there are none.
double distance_to(std::span<const Solid> solids, Vec2 point);
/// Distance [m] between a solid and a convex, counter-clockwise polygon; 0 where they overlap.
double distance_to(const Solid& solid, std::span<const Vec2> polygon);
/// Whether a solid and a convex, counter-clockwise polygon overlap deeper than `depth` [m]; touching is no overlap.
bool overlaps(const Solid& solid, std::span<const Vec2> polygon, double depth = 0.0);
/// The same for two solids, seen from above; their heights are not compared.
bool overlaps(const Solid& a, const Solid& b, double depth = 0.0);

/// A straight edge of a solid shape. Shapes list their edges counter-clockwise, so the solid lies to the left of a ->
/// b. `object` is the index of what it belongs to in `Scene::objects`, or -1 for walls.
struct Segment {
  Vec2 a;           ///< [m] where it begins
  Vec2 b;           ///< [m] where it ends
  int object = -1;  ///< index into `Scene::objects`, -1 for walls
};

/// A disc in the plane.
struct Circle {
  Vec2 center;          ///< [m]
  double radius = 0.0;  ///< [m]
  int object = -1;      ///< index into `Scene::objects`, -1 for none
};

/// Everything that a horizontal plane, or a slab between two heights, cuts out of a scene.
struct Slice {
  std::vector<Segment> segments;  ///< edges of rectangles and walls
  std::vector<Circle> circles;    ///< cylinders
};

/// Range [m] along a ray to the nearest shape, or `range_max`: every shape is tried. Shapes are seen from outside: a
/// ray that begins inside one leaves it unhindered. The slow, obvious twin of the lidar, also used by metrics.
double cast_ray(const Slice& slice, Vec2 origin, double angle, double range_max);

/// The outlines of solids. Of several with one outline, as the boards of a shelf, the first is taken.
Slice outlines(std::span<const Solid> solids);

}  // namespace threewe::scene
