#include "task/sight.hpp"

#include <cmath>
#include <vector>

#include "camera_frame.hpp"
#include "core/numbers.hpp"

namespace threewe::task {
namespace {

using scene::Solid;

// A solid in the camera's frame.
struct Standing {
  Solid::Shape shape{};
  std::array<Vec2, 4> corners;
  Vec2 center;
  double radius = 0.0;
  Range heights;  // above the eye
  Range columns;  // outside of these `t` no ray meets it
};

Standing in_camera_frame(const Solid& solid, const Eye& eye, const Pose2D& camera_from_scene) {
  Standing s;
  s.shape = solid.shape;
  s.center = camera_from_scene * solid.center;
  s.radius = solid.radius;
  s.heights = {solid.z_min - eye.height, solid.z_max - eye.height};
  s.columns = {-kInfinity, kInfinity};
  if (s.shape == Solid::Shape::disc) return s;
  for (std::size_t i = 0; i < 4; ++i) s.corners[i] = camera_from_scene * solid.corners[i];
  Range seen{kInfinity, -kInfinity};
  for (const Vec2 c : s.corners) {
    if (c.x < 1e-3) return s;  // beside the eye, or behind it in part
    seen = {std::min(seen.from, c.y / c.x), std::max(seen.to, c.y / c.x)};
  }
  s.columns = {seen.from - 1e-9, seen.to + 1e-9};
  return s;
}

// What a column's ray meets of a solid.
struct Slab {
  Range depth;
  Range heights;

  // The slopes of the rays in this column that meet it.
  Range slopes() const {
    if (depth.empty() || depth.to <= 0.0) return {1.0, 0.0};
    if (depth.from > 0.0) {
      return {std::min(heights.from / depth.from, heights.from / depth.to),
              std::max(heights.to / depth.from, heights.to / depth.to)};
    }
    // the eye is above it, below it or inside
    if (heights.from > 0.0) return {heights.from / depth.to, kInfinity};
    if (heights.to < 0.0) return {-kInfinity, heights.to / depth.to};
    return {1.0, 0.0};
  }

  // The depth at which the ray of a slope meets it; infinity if never.
  double entry(double slope) const {
    Range d = depth;
    if (slope == 0.0 && (heights.from > 0.0 || heights.to < 0.0)) return kInfinity;
    if (slope != 0.0) {
      const double a = heights.from / slope;
      const double b = heights.to / slope;
      d = {std::max(d.from, std::min(a, b)), std::min(d.to, std::max(a, b))};
    }
    return d.empty() || d.from <= 0.0 ? kInfinity : d.from;
  }
};

// The slabs of a column; false if there are none.
bool cut(const std::vector<Standing>& solids, double t, double farthest, std::vector<Slab>& slabs) {
  slabs.clear();
  for (const Standing& s : solids) {
    if (t < s.columns.from || t > s.columns.to) continue;
    const Range depth = s.shape == Solid::Shape::box ? crossing(s.corners, t) : crossing(s.center, s.radius, t);
    if (!depth.empty() && depth.to > 0.0 && depth.from < farthest) slabs.push_back({depth, s.heights});
  }
  return !slabs.empty();
}

double nearest_entry(const std::vector<Slab>& slabs, double slope) {
  double nearest = kInfinity;
  for (const Slab& slab : slabs) nearest = std::min(nearest, slab.entry(slope));
  return nearest;
}

std::vector<Standing> stand(std::span<const Solid> solids, const Eye& eye) {
  const Pose2D camera_from_scene = inverse(eye.pose);
  std::vector<Standing> standing;
  for (const Solid& solid : solids) {
    standing.push_back(in_camera_frame(solid, eye, camera_from_scene));
    const Standing& s = standing.back();
    if (s.center.x + s.radius <= 0.0) standing.pop_back();  // behind
  }
  return standing;
}

}  // namespace

int visible_pixels(const CameraIntrinsics& camera, const Eye& eye, std::span<const Solid> object,
                   std::span<const Solid> others) {
  const std::vector<Standing> seen = stand(object, eye);
  const std::vector<Standing> before = stand(others, eye);
  std::vector<Slab> slabs;
  std::vector<Slab> hiding;
  std::vector<Range> rows;
  int count = 0;
  for (int column = 0; column < camera.width; ++column) {
    const double t = (camera.cx - (column + 0.5)) / camera.fx;
    if (!cut(seen, t, kInfinity, slabs)) continue;

    // the rows of each slab, from the top; together, where they overlap
    rows.clear();
    double farthest = 0.0;
    for (const Slab& slab : slabs) {
      const Range slopes = slab.slopes();
      if (slopes.empty()) continue;
      const double first = std::ceil(camera.cy - camera.fy * slopes.to - 0.5);
      const double last = std::floor(camera.cy - camera.fy * slopes.from - 0.5);
      rows.push_back({std::max(first, 0.0), std::min(last, camera.height - 1.0)});
      farthest = std::max(farthest, slab.depth.to);
    }
    std::ranges::sort(rows, {}, &Range::from);

    const bool all_seen = before.empty() || !cut(before, t, farthest, hiding);
    int next = 0;  // the first row that is not yet counted
    for (const Range& range : rows) {
      if (range.empty()) continue;
      const int first = std::max(next, static_cast<int>(range.from));
      const int last = static_cast<int>(range.to);
      for (int row = first; row <= last; ++row) {
        const double slope = (camera.cy - (row + 0.5)) / camera.fy;
        if (all_seen) {
          count += last - row + 1;
          break;
        }
        if (nearest_entry(slabs, slope) < nearest_entry(hiding, slope)) ++count;
      }
      next = std::max(next, last + 1);
    }
  }
  return count;
}

}  // namespace threewe::task
