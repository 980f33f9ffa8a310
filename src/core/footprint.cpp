#include "threewe/core/footprint.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/exact.hpp"
#include "threewe/core/errors.hpp"

namespace threewe {

double signed_distance(std::span<const Vec2> polygon, Vec2 point) {
  bool inside = true;
  double square = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2 a = polygon[i];
    const Vec2 b = polygon[i + 1 == polygon.size() ? 0 : i + 1];
    inside = inside && cross(b - a, point - a) >= 0.0;
    const Vec2 off = point - closest_on_segment(point, a, b);
    square = std::min(square, dot(off, off));
  }
  const double nearest = exact::sqrt(square);
  return inside ? -nearest : nearest;
}

Footprint::Footprint(std::vector<Vec2> corners) : corners_(std::move(corners)) {
  const std::size_t n = corners_.size();
  if (n < 3) throw ConfigError("footprint needs at least 3 corners");
  inscribed_radius_ = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < n; ++i) {
    const Vec2 a = corners_[i];
    const Vec2 b = corners_[(i + 1) % n];
    if (!std::isfinite(a.x) || !std::isfinite(a.y)) throw ConfigError("footprint must have finite corners");
    for (std::size_t k = 2; k < n; ++k) {  // every other corner lies to the left of a -> b
      const Vec2 c = corners_[(i + k) % n];
      if (!(cross(b - a, c - b) > 0.0)) throw ConfigError("footprint must be convex, its corners counter-clockwise");
    }
    if (!(cross(b - a, Vec2{} - a) > 0.0)) throw ConfigError("footprint must contain the base (0, 0)");
    inscribed_radius_ = std::min(inscribed_radius_, distance_to_segment({}, a, b));
    circumscribed_radius_ = std::max(circumscribed_radius_, norm(a));
    low_ = {std::min(low_.x, a.x), std::min(low_.y, a.y)};
    high_ = {std::max(high_.x, a.x), std::max(high_.y, a.y)};
  }
  is_box_ = n == 4 && std::ranges::all_of(corners_, [&](Vec2 p) {
              return (p.x == low_.x || p.x == high_.x) && (p.y == low_.y || p.y == high_.y);
            });
}

double Footprint::farthest_corner(Vec2 point_in_base) const {
  double farthest = 0.0;
  for (const Vec2 corner : corners_) farthest = std::max(farthest, distance(corner, point_in_base));
  return farthest;
}

Footprint Footprint::rectangle(double length, double width) {
  const double x = 0.5 * length;
  const double y = 0.5 * width;
  return Footprint({{x, -y}, {x, y}, {-x, y}, {-x, -y}});
}

}  // namespace threewe
