#include "core/exact.hpp"
#include "threewe/scene/solid.hpp"

#include <algorithm>
#include <limits>

namespace threewe::scene {
namespace {

constexpr double kMiss = std::numeric_limits<double>::infinity();

double range_to(const Segment& segment, Vec2 origin, Vec2 direction) {
  const Vec2 a = segment.a - origin;
  const Vec2 b = segment.b - origin;
  const Vec2 along = segment.b - segment.a;
  const double height = cross(along, a);            // of the origin above the line, on its free side, times length
  const double approach = cross(along, direction);  // how fast the ray comes down, times length
  const bool between = cross(direction, a) >= 0.0 && cross(direction, b) <= 0.0;
  return height > 0.0 && approach > 0.0 && between ? height / approach : kMiss;
}

double range_to(const Circle& circle, Vec2 origin, Vec2 direction) {
  const Vec2 center = circle.center - origin;
  const double ahead = dot(direction, center);
  const double aside = cross(direction, center);
  const double half_chord_squared = circle.radius * circle.radius - aside * aside;
  const bool outside = dot(center, center) > circle.radius * circle.radius;
  return outside && ahead > 0.0 && half_chord_squared >= 0.0 ? ahead - exact::sqrt(half_chord_squared) : kMiss;
}

}  // namespace

double cast_ray(const Slice& slice, Vec2 origin, double angle, double range_max) {
  const auto [s, c] = exact::sincos(angle);
  double range = range_max;
  for (const Segment& segment : slice.segments) range = std::min(range, range_to(segment, origin, {c, s}));
  for (const Circle& circle : slice.circles) range = std::min(range, range_to(circle, origin, {c, s}));
  return range;
}

}  // namespace threewe::scene
