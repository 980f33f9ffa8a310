// Camera view in the plane of the floor: pose and projection, x ahead, y to the left.
#pragma once

#include <limits>

#include "core/exact.hpp"
#include "sim/renderer/place.hpp"

namespace threewe::sim::view {

struct View {
  CameraIntrinsics camera;
  Vec2 eye;
  double height = 0.0;  // [m] of the eye
  Vec2 forward;
  Vec2 left;
  bool is_roofed = false;  // below a ceiling

  View(const CameraIntrinsics& intrinsics, const CameraPose& pose, double ceiling)
      : camera(intrinsics), eye(pose.pose.position()), height(pose.height) {
    const auto [s, c] = exact::sincos(pose.pose.theta);
    forward = {c, s};
    left = {-s, c};
    is_roofed = height < ceiling && ceiling < std::numeric_limits<double>::infinity();
  }

  /// y / x of the rays in a column.
  double slope_of(int column) const { return (camera.cx - (column + 0.5)) / camera.fx; }
  /// Where the rays of a column go in the scene's frame; 1 along the optical axis.
  Vec2 direction(double slope) const { return forward + slope * left; }
  Vec2 to_camera(Vec2 point) const {
    const Vec2 d = point - eye;
    return {dot(d, forward), dot(d, left)};
  }
  /// The first row whose centre is at or below a height (relative to the eye) seen at an inverse depth.
  int row_at(double z, double inverse) const {
    const double v = camera.cy - camera.fy * (z * inverse) - 0.5;
    if (!(v > 0.0)) return 0;
    if (v >= camera.height) return camera.height;
    const int above = static_cast<int>(v);
    return above < v ? above + 1 : above;
  }
};

}  // namespace threewe::sim::view
