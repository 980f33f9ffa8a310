#include "view_bound.hpp"
#include "core/exact.hpp"
#include "core/numbers.hpp"

#include <utility>

namespace threewe::task {
namespace {

using scene::Solid;

constexpr double kNear = 0.01;  // [m] in front of the eye: what is nearer is cut off

// A box as it is; of a disc an octagon inside it.
Polygon inner_polygon(const Solid& solid) {
  Polygon polygon;
  if (solid.shape == Solid::Shape::box) {
    for (const Vec2 corner : solid.corners) polygon.add(corner);
    return polygon;
  }
  for (int i = 0; i < 8; ++i) {
    polygon.add(solid.center + rotate({solid.radius, 0.0}, wrap_angle(0.25 * i * exact::kPi)));
  }
  return polygon;
}

// The rectangle along an object's axes that holds all of it.
Polygon rectangle_around(std::span<const Solid> solids, const Pose2D& scene_from_object) {
  Vec2 low{kInfinity, kInfinity};
  Vec2 high{-kInfinity, -kInfinity};
  const auto hold = [&](Vec2 p, double radius) {
    low = {std::min(low.x, p.x - radius), std::min(low.y, p.y - radius)};
    high = {std::max(high.x, p.x + radius), std::max(high.y, p.y + radius)};
  };
  const Pose2D object_from_scene = inverse(scene_from_object);
  for (const Solid& solid : solids) {
    if (solid.shape == Solid::Shape::disc) hold(object_from_scene * solid.center, solid.radius);
    if (solid.shape == Solid::Shape::box) {
      for (const Vec2 corner : solid.corners) hold(object_from_scene * corner, 0.0);
    }
  }
  Polygon rectangle;
  for (const Vec2 corner : {low, Vec2{high.x, low.y}, high, Vec2{low.x, high.y}}) {
    rectangle.add(scene_from_object * corner);
  }
  return rectangle;
}

Polygon in_frame(const Polygon& polygon, const Pose2D& frame_from_scene) {
  Polygon moved;
  for (const Vec2 corner : polygon.corners()) moved.add(frame_from_scene * corner);
  return moved;
}

// What is ahead of the eye.
Polygon ahead(const Polygon& polygon) {
  const bool all = std::ranges::all_of(polygon.corners(), [](Vec2 p) { return p.x >= kNear; });
  return all ? polygon : clip(polygon, [](Vec2 p) { return p.x - kNear; });
}

// The rays y = t x that meet a polygon ahead of the eye.
Range rays(const Polygon& polygon) {
  Range range{kInfinity, -kInfinity};
  for (const Vec2 c : polygon.corners()) {
    const double t = c.y / c.x;
    range = {std::min(range.from, t), std::max(range.to, t)};
  }
  return range;
}

// The rows that an object between two heights above the eye, at these depths, can fill.
double most_rows(const CameraIntrinsics& camera, Range heights, Range depth) {
  const double top = std::min(std::max(heights.to / depth.from, heights.to / depth.to), camera.cy / camera.fy);
  const double bottom =
      std::max(std::min(heights.from / depth.from, heights.from / depth.to), (camera.cy - camera.height) / camera.fy);
  return top < bottom ? 0.0 : (top - bottom) * camera.fy + 1.0;
}

}  // namespace

ViewBound::ViewBound(const scene::Scene& scene, std::span<const Solid> solids, std::span<const int> objects,
                     double eye_height) {
  for (const int index : objects) {
    std::vector<Solid> own;
    Bounded object{.outline = {}, .center = {}, .radius = 0.0, .z_min = kInfinity, .z_max = -kInfinity, .hiding = {}};
    for (const Solid& solid : solids) {
      if (solid.object != index) continue;
      own.push_back(solid);
      object.z_min = std::min(object.z_min, solid.z_min);
      object.z_max = std::max(object.z_max, solid.z_max);
    }
    object.outline = rectangle_around(own, scene.objects[static_cast<std::size_t>(index)].pose);
    object.center = 0.5 * (object.outline.corners()[0] + object.outline.corners()[2]);
    object.radius = distance(object.center, object.outline.corners()[0]);
    objects_.push_back(std::move(object));
  }

  for (const Solid& solid : solids) {
    bool hides_any = false;
    for (Bounded& object : objects_) {
      const bool hides = solid.z_min <= std::min(eye_height, object.z_min) &&
                         solid.z_max >= std::max(eye_height, object.z_max) &&
                         !overlaps(solid, object.outline.corners());
      if (hides) object.hiding.push_back(tall_.size());
      hides_any = hides_any || hides;
    }
    if (hides_any) tall_.push_back(inner_polygon(solid));
  }
}

// From one eye.
class ViewBound::View {
 public:
  View(const ViewBound& bound, const CameraIntrinsics& camera, const Eye& eye)
      : bound_(bound),
        camera_(camera),
        eye_height_(eye.height),
        camera_from_scene_(inverse(eye.pose)),
        left_(camera.cx / camera.fx),
        right_((camera.cx - camera.width) / camera.fx) {}

  // The depth of an object that may be inside the picture's edges, or infinity.
  double depth(const Bounded& object) const {
    const Vec2 c = camera_from_scene_ * object.center;
    const double r = object.radius;
    const bool outside =
        c.x + r < 0.0 || c.y - left_ * c.x > r * (1.0 + left_) || right_ * c.x - c.y > r * (1.0 - right_);
    return outside ? kInfinity : c.x;
  }

  double most_pixels(const Bounded& object) {
    Polygon seen = ahead(in_frame(object.outline, camera_from_scene_));
    seen = clip(clip(seen, [&](Vec2 p) { return left_ * p.x - p.y; }), [&](Vec2 p) { return p.y - right_ * p.x; });
    if (seen.corners().empty()) return 0.0;
    const auto depth = std::ranges::minmax(seen.corners(), {}, &Vec2::x);
    const double rows =
        most_rows(camera_, {object.z_min - eye_height_, object.z_max - eye_height_}, {depth.min.x, depth.max.x});
    if (rows == 0.0) return 0.0;

    // without the rays that meet something tall before
    const Range all = rays(seen);
    hidden_.clear();
    for (const std::size_t index : object.hiding) {
      const Ahead& tall = at(index);
      const Range both{std::max(tall.rays.from, all.from), std::min(tall.rays.to, all.to)};
      if (both.empty()) continue;
      // of two convex shapes that do not overlap, the same one is before the other along every ray that meets both
      const double middle = 0.5 * (both.from + both.to);
      if (crossing(tall.outline.corners(), middle).from < crossing(seen.corners(), middle).from) {
        hidden_.push_back(both);
      }
    }
    return columns_left(all) * rows;
  }

 private:
  struct Ahead {
    bool known = false;
    Polygon outline;
    Range rays{kInfinity, -kInfinity};
  };

  const Ahead& at(std::size_t index) {
    if (ahead_.empty()) ahead_.resize(bound_.tall_.size());
    Ahead& a = ahead_[index];
    if (a.known) return a;
    a.known = true;
    a.outline = ahead(in_frame(bound_.tall_[index], camera_from_scene_));
    a.rays = rays(a.outline);
    return a;
  }

  double columns_left(const Range& all) {
    std::ranges::sort(hidden_, {}, &Range::from);
    double columns = 0.0;
    double open = all.from;  // the first ray that nothing hides yet
    for (const Range& range : hidden_) {
      if (range.from > open) columns += (range.from - open) * camera_.fx + 1.0;
      open = std::max(open, range.to);
    }
    return all.to > open ? columns + (all.to - open) * camera_.fx + 1.0 : columns;
  }

  const ViewBound& bound_;
  const CameraIntrinsics& camera_;
  double eye_height_;
  Pose2D camera_from_scene_;
  double left_;
  double right_;
  std::vector<Ahead> ahead_;
  std::vector<Range> hidden_;
};

bool ViewBound::may_see(const CameraIntrinsics& camera, const Eye& eye, double pixels) const {
  // the nearest first: they are the likeliest to be seen
  View view(*this, camera, eye);
  std::vector<std::pair<double, const Bounded*>> near;
  for (const Bounded& object : objects_) {
    const double depth = view.depth(object);
    if (depth < kInfinity) near.emplace_back(depth, &object);
  }
  std::ranges::sort(near, {}, &std::pair<double, const Bounded*>::first);
  return std::ranges::any_of(near, [&](const auto& object) { return view.most_pixels(*object.second) >= pixels; });
}

}  // namespace threewe::task
