// The robot's outline on the floor.
#pragma once

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

  const std::vector<Vec2>& corners() const { return corners_; }
  /// Radius of the largest disc around the base inside the outline [m].
  double inscribed_radius() const { return inscribed_radius_; }
  /// Radius of the smallest disc around the base that holds the outline [m].
  double circumscribed_radius() const { return circumscribed_radius_; }
  bool contains(Vec2 point_in_base) const { return signed_distance(point_in_base) <= 0.0; }
  /// Distance from a point to the outline [m], negative inside.
  double signed_distance(Vec2 point_in_base) const { return threewe::signed_distance(corners_, point_in_base); }
  /// Whether a point is in the rectangle that leaves `margin` [m] around the outline: cheap, and true of all that is
  /// nearer than that.
  bool may_be_near(Vec2 point_in_base, double margin) const {
    return point_in_base.x >= low_.x - margin && point_in_base.x <= high_.x + margin &&
           point_in_base.y >= low_.y - margin && point_in_base.y <= high_.y + margin;
  }
  friend bool operator==(const Footprint&, const Footprint&) = default;

 private:
  std::vector<Vec2> corners_;
  double inscribed_radius_ = 0.0;
  double circumscribed_radius_ = 0.0;
  Vec2 low_;  // corners of the rectangle around it
  Vec2 high_;
};

}  // namespace threewe
