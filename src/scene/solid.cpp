#include "threewe/scene/solid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/exact.hpp"
#include "core/numbers.hpp"
#include "threewe/core/footprint.hpp"

namespace threewe::scene {
namespace {

// The unit vector at an angle; exactly along an axis for quarter turns, whose sine and cosine are off by a rounding.
Vec2 unit_vector(double theta) {
  constexpr double kNegligible = 1e-12;
  const auto [s, c] = exact::sincos(theta);
  if (std::fabs(s) < kNegligible) return {c > 0.0 ? 1.0 : -1.0, 0.0};
  if (std::fabs(c) < kNegligible) return {0.0, s > 0.0 ? 1.0 : -1.0};
  return {c, s};
}

// Distance from a point to a convex polygon; 0 inside.
double distance_to_polygon(std::span<const Vec2> polygon, Vec2 p) { return std::max(0.0, signed_distance(polygon, p)); }

// Whether all of `other` lies beyond an edge of `polygon`, or less than `depth` behind it: then that edge separates
// them.
bool has_separating_edge(std::span<const Vec2> polygon, std::span<const Vec2> other, double depth) {
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2 a = polygon[i];
    const Vec2 edge = polygon[(i + 1) % polygon.size()] - a;
    double deepest = -std::numeric_limits<double>::infinity();
    for (const Vec2 p : other) deepest = std::max(deepest, cross(edge, p - a));
    if (deepest <= depth * norm(edge)) return true;
  }
  return false;
}

// Convex polygons overlap unless an edge of one of them separates them (separating axis theorem).
bool polygons_overlap(std::span<const Vec2> a, std::span<const Vec2> b, double depth) {
  return !has_separating_edge(a, b, depth) && !has_separating_edge(b, a, depth);
}

bool same_outline(const Solid& a, const Solid& b) {
  return a.shape == b.shape && a.object == b.object && a.center == b.center && a.radius == b.radius &&
         a.corners == b.corners;
}

}  // namespace

Solid make_box(const Pose2D& middle, double length, double width) {
  const Vec2 x = unit_vector(middle.theta);
  const Vec2 along = 0.5 * length * x;
  const Vec2 across = 0.5 * width * Vec2{-x.y, x.x};
  const Vec2 c = middle.position();
  Solid solid;
  solid.shape = Solid::Shape::box;
  solid.corners = {c - along - across, c + along - across, c + along + across, c - along + across};
  solid.center = c;
  solid.radius = 0.5 * exact::hypot(length, width);
  return solid;
}

Solid make_disc(Vec2 center, double radius) {
  Solid solid;
  solid.shape = Solid::Shape::disc;
  solid.center = center;
  solid.radius = radius;
  return solid;
}

std::pair<Vec2, Vec2> bounds(const Solid& solid) {
  const Vec2 r{solid.radius, solid.radius};
  if (solid.shape == Solid::Shape::disc) return {solid.center - r, solid.center + r};
  const auto x = std::ranges::minmax(solid.corners, {}, &Vec2::x);
  const auto y = std::ranges::minmax(solid.corners, {}, &Vec2::y);
  return {{x.min.x, y.min.y}, {x.max.x, y.max.y}};
}

std::pair<Vec2, Vec2> bounds(std::span<const Solid> solids) {
  Vec2 low{kInfinity, kInfinity};
  Vec2 high{-kInfinity, -kInfinity};
  for (const Solid& solid : solids) {
    const auto [a, b] = bounds(solid);
    low = {std::min(low.x, a.x), std::min(low.y, a.y)};
    high = {std::max(high.x, b.x), std::max(high.y, b.y)};
  }
  return {low, high};
}

double distance_to(const Solid& solid, Vec2 point) {
  if (solid.shape == Solid::Shape::disc) return std::max(0.0, distance(solid.center, point) - solid.radius);
  return distance_to_polygon(solid.corners, point);
}

double distance_to(std::span<const Solid> solids, Vec2 point) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Solid& solid : solids) nearest = std::min(nearest, distance_to(solid, point));
  return nearest;
}

double distance_to(const Solid& solid, std::span<const Vec2> polygon) {
  if (solid.shape == Solid::Shape::disc) {
    return std::max(0.0, distance_to_polygon(polygon, solid.center) - solid.radius);
  }
  if (polygons_overlap(solid.corners, polygon, 0.0)) return 0.0;
  // between disjoint convex polygons the nearest points include a corner of one of them
  double nearest = std::numeric_limits<double>::infinity();
  for (const Vec2 p : polygon) nearest = std::min(nearest, distance_to_polygon(solid.corners, p));
  for (const Vec2 p : solid.corners) nearest = std::min(nearest, distance_to_polygon(polygon, p));
  return nearest;
}

bool overlaps(const Solid& solid, std::span<const Vec2> polygon, double depth) {
  if (solid.shape == Solid::Shape::disc) return distance_to_polygon(polygon, solid.center) < solid.radius - depth;
  return polygons_overlap(solid.corners, polygon, depth);
}

bool overlaps(const Solid& a, const Solid& b, double depth) {
  if (distance(a.center, b.center) >= a.radius + b.radius) return false;
  if (b.shape == Solid::Shape::box) return overlaps(a, b.corners, depth);
  if (a.shape == Solid::Shape::box) return overlaps(b, a.corners, depth);
  return distance(a.center, b.center) < a.radius + b.radius - depth;
}

Slice outlines(std::span<const Solid> solids) {
  Slice slice;
  for (std::size_t i = 0; i < solids.size(); ++i) {
    const Solid& solid = solids[i];

    // an object's solids stand next to each other, so that its earlier ones are quickly searched
    bool seen = false;
    for (std::size_t j = i; j-- > 0 && solids[j].object == solid.object && solid.object >= 0 && !seen;) {
      seen = same_outline(solids[j], solid);
    }
    if (seen) continue;

    if (solid.shape == Solid::Shape::disc) {
      slice.circles.push_back({solid.center, solid.radius, solid.object});
      continue;
    }
    for (std::size_t k = 0; k < 4; ++k) {
      slice.segments.push_back({solid.corners[k], solid.corners[(k + 1) % 4], solid.object});
    }
  }
  return slice;
}

}  // namespace threewe::scene
