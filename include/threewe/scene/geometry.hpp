// The shapes of a scene in one horizontal plane, exact: no grid.
#pragma once

#include <vector>

#include "threewe/core/pose.hpp"

namespace threewe::scene {

/// A straight edge of a solid shape. Shapes list their edges counter-clockwise, so the solid lies to the left of a ->
/// b. `object` is the index of what it belongs to in `Scene::objects`, or -1 for walls.
struct Segment {
  Vec2 a;
  Vec2 b;
  int object = -1;
};

struct Circle {
  Vec2 center;
  double radius = 0.0;
  int object = -1;
};

/// Everything that a horizontal plane, or a slab between two heights, cuts out of a scene.
struct Slice {
  std::vector<Segment> segments;
  std::vector<Circle> circles;
};

/// Range [m] along a ray to the nearest shape, or `range_max`: every shape is tried. Shapes are seen from outside: a
/// ray that begins inside one leaves it unhindered. The slow, obvious twin of the lidar, also used by metrics.
double cast_ray(const Slice& slice, Vec2 origin, double angle, double range_max);

}  // namespace threewe::scene
