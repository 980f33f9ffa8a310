// Outlines in the frame of a level camera: x along the optical axis and y to the left.
//
// A column of the picture is a ray y = t x in that plane; along it depth is x, and a row is a slope of height over
// depth.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include "core/exact.hpp"
#include "core/numbers.hpp"
#include "task/sight.hpp"
#include "threewe/scene/solid.hpp"

namespace threewe::task {

/// From where to where something reaches, along a line: nothing where `to` < `from`.
struct Range {
  double from = 0.0;
  double to = 0.0;
  bool empty() const { return !(from <= to); }
};

/// A convex, counter-clockwise polygon of few corners.
class Polygon {
 public:
  void add(Vec2 corner) { corners_[count_++] = corner; }
  std::span<const Vec2> corners() const { return {corners_.data(), count_}; }

 private:
  std::array<Vec2, 12> corners_{};
  std::size_t count_ = 0;
};

/// The part of a polygon where `side(point)`, which must be linear, is not negative.
template <typename Side>
Polygon clip(const Polygon& polygon, Side side) {
  Polygon clipped;
  const std::span<const Vec2> corners = polygon.corners();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2 a = corners[i];
    const Vec2 b = corners[(i + 1) % corners.size()];
    const double side_a = side(a);
    const double side_b = side(b);
    if (side_a >= 0.0) clipped.add(a);
    if ((side_a >= 0.0) != (side_b >= 0.0)) clipped.add(a + (side_a / (side_a - side_b)) * (b - a));
  }
  return clipped;
}

/// Where the ray y = t x crosses a convex polygon, in depth.
inline Range crossing(std::span<const Vec2> polygon, double t) {
  Range depth{-kInfinity, kInfinity};
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2 a = polygon[i];
    const Vec2 edge = polygon[(i + 1) % polygon.size()] - a;
    // inside is where offset + slope * depth >= 0
    const double offset = cross(a, edge);
    const double slope = cross(edge, {1.0, t});
    if (slope > 0.0) depth.from = std::max(depth.from, -offset / slope);
    if (slope < 0.0) depth.to = std::min(depth.to, -offset / slope);
    if (slope == 0.0 && offset < 0.0) return {1.0, 0.0};
  }
  return depth;
}

/// Where it crosses a disc.
inline Range crossing(Vec2 center, double radius, double t) {
  const double a = 1.0 + t * t;
  const double b = center.x + t * center.y;
  const double discriminant = b * b - a * (dot(center, center) - radius * radius);
  if (discriminant < 0.0) return {1.0, 0.0};
  const double root = exact::sqrt(discriminant);
  return {(b - root) / a, (b + root) / a};
}

}  // namespace threewe::task
