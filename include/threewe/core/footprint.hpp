// Robot footprint: a convex polygon on the floor around the base.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "threewe/core/pose.hpp"

namespace threewe {

/// Distance from a point to the outline of a convex polygon, its corners counter-clockwise [m]; negative inside.
double signed_distance(std::span<const Vec2> polygon, Vec2 point);

/// A convex polygon around the base, counter-clockwise [m].
class Footprint {
 public:
  Footprint() = default;
  /// Throws ConfigError unless `corners` is a convex, counter-clockwise polygon that contains the base.
  explicit Footprint(std::vector<Vec2> corners);
  /// A rectangle centred on the base, `length` along x and `width` along y [m].
  static Footprint rectangle(double length, double width);

  /// The corners [m] in the base frame, counter-clockwise.
  const std::vector<Vec2>& corners() const { return corners_; }
  /// Radius of the largest disc around the base inside the outline [m].
  double inscribed_radius() const { return inscribed_radius_; }
  /// Radius of the smallest disc around the base that holds the outline [m].
  double circumscribed_radius() const { return circumscribed_radius_; }
  /// Distance from a point [m] to the farthest corner [m].
  double farthest_corner(Vec2 point_in_base) const;
  /// Whether a point [m] is inside or on the border.
  bool contains(Vec2 point_in_base) const { return signed_distance(point_in_base) <= 0.0; }
  /// Distance from a point to the outline [m], negative inside.
  double signed_distance(Vec2 point_in_base) const {
    if (!is_box_) return threewe::signed_distance(corners_, point_in_base);
    const Vec2 off = beyond_box(point_in_base);
    return off.x <= 0.0 && off.y <= 0.0 ? std::max(off.x, off.y) : distance_to_box(point_in_base);
  }
  /// Distance from a point to the rectangle around the outline [m], 0 inside it: cheap, and from outside never more
  /// than the distance to the outline.
  double distance_to_box(Vec2 point_in_base) const {
    const Vec2 off = beyond_box(point_in_base);
    return norm({std::max(off.x, 0.0), std::max(off.y, 0.0)});
  }
  friend bool operator==(const Footprint&, const Footprint&) = default;

 private:
  // How far a point lies beyond the nearer sides of the rectangle, along x and along y; negative between them.
  Vec2 beyond_box(Vec2 p) const {
    return {std::max(low_.x - p.x, p.x - high_.x), std::max(low_.y - p.y, p.y - high_.y)};
  }

  std::vector<Vec2> corners_;
  double inscribed_radius_ = 0.0;
  double circumscribed_radius_ = 0.0;
  Vec2 low_;  // corners of the rectangle around it
  Vec2 high_;
  bool is_box_ = false;  // the outline is that rectangle
};

}  // namespace threewe
