// What a camera sees, ray by ray: the slow, obvious way.
#pragma once

#include <algorithm>
#include <limits>
#include <span>
#include <vector>

#include "core/exact.hpp"
#include "task/sight.hpp"

namespace threewe::task {

/// The depth at which the ray from the origin along (1, t, slope), in the camera's frame, enters a solid from outside.
inline double slow_entry(const scene::Solid& solid, const Eye& eye, double t, double slope) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const Vec2 direction = rotate({1.0, t}, eye.pose.theta);
  const Vec2 origin = eye.pose.position();
  double from = -kInfinity;
  double to = kInfinity;
  // where a + b * depth is between low and high
  const auto between = [&](double a, double b, double low, double high) {
    if (b == 0.0) {
      if (a < low || a > high) to = -kInfinity;
      return;
    }
    from = std::max(from, std::min((low - a) / b, (high - a) / b));
    to = std::min(to, std::max((low - a) / b, (high - a) / b));
  };
  between(eye.height, slope, solid.z_min, solid.z_max);
  if (solid.shape == scene::Solid::Shape::box) {
    const Vec2 corner = solid.corners[0];
    for (const Vec2 side : {solid.corners[1] - corner, solid.corners[3] - corner}) {
      between(dot(origin - corner, side), dot(direction, side), 0.0, dot(side, side));
    }
  } else {
    const Vec2 o = origin - solid.center;
    const double a = dot(direction, direction);
    const double b = dot(o, direction);
    const double discriminant = b * b - a * (dot(o, o) - solid.radius * solid.radius);
    if (discriminant < 0.0) return kInfinity;
    from = std::max(from, (-b - exact::sqrt(discriminant)) / a);
    to = std::min(to, (-b + exact::sqrt(discriminant)) / a);
  }
  return from > 0.0 && from <= to ? from : kInfinity;
}

/// For every pixel, the index into `solids` of what it shows, or -1.
inline std::vector<int> slow_picture(const CameraIntrinsics& camera, const Eye& eye,
                                     std::span<const scene::Solid> solids) {
  std::vector<int> picture;
  for (int row = 0; row < camera.height; ++row) {
    for (int column = 0; column < camera.width; ++column) {
      double nearest = std::numeric_limits<double>::infinity();
      picture.push_back(-1);
      for (std::size_t i = 0; i < solids.size(); ++i) {
        const double t = (camera.cx - (column + 0.5)) / camera.fx;
        const double entry = slow_entry(solids[i], eye, t, (camera.cy - (row + 0.5)) / camera.fy);
        if (entry >= nearest) continue;
        nearest = entry;
        picture.back() = static_cast<int>(i);
      }
    }
  }
  return picture;
}

}  // namespace threewe::task
