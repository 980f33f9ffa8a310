#include "sim/renderer/candidates.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/numbers.hpp"

namespace threewe::sim::view {
namespace {

using scene::Solid;

constexpr double kNear = 1e-6;  // [m]

// What a thing covers of the picture, widened by rounding.
struct Reach {
  int first_block = 0;
  int last_block = 0;
  double nearest = 0.0;  // inverse depth
};

class Search {
 public:
  Search(const Place& place, const View& view, Candidates& out)
      : place_(place), view_(view), out_(out), width_(static_cast<std::size_t>(block_width())) {}

  void run(std::span<const VisibleSolid> moving) {
    begin(moving.size());
    for (const std::uint32_t i : out_.groups) {
      if (hides_all(place_.groups[i])) add_wall(place_.groups[i].first);
    }
    find_nearest_walls();
    for (const std::uint32_t i : out_.groups) {
      const Group& group = place_.groups[i];
      if (hides_all(group) || is_hidden(group)) continue;
      for (std::size_t k = group.first; k < group.last; ++k) {
        add_other(place_.solids[k], place_.sides[k], static_cast<int>(k));
      }
    }
    for (const VisibleSolid& visible : moving) {
      add_other(visible, out_.moving.emplace_back(make_sides(visible, place_.is_open)), -1);
    }
  }

 private:
  void begin(std::size_t moving) {
    const auto columns = static_cast<std::size_t>(view_.camera.width);
    const std::size_t blocks = (columns + width_ - 1) / width_;
    const FloorRegion* floor = place_.floor_at(view_.eye);
    out_.floor = floor ? static_cast<std::size_t>(floor - place_.floors.data()) : place_.floors.size();
    out_.groups.resize(place_.circles.x.size());
    const double most = view_.slope_of(-1);
    const double least = view_.slope_of(view_.camera.width);
    const Sector sector{view_.eye, view_.forward, view_.left, most, least};
    out_.groups.resize(find_within(place_.circles, sector, out_.groups.data()));
    out_.walls.clear();
    out_.others.clear();
    out_.moving.clear();
    out_.moving.reserve(moving);  // candidates point into it
    out_.blocks.resize(blocks);
    for (auto& block : out_.blocks) block.clear();
    out_.farthest.assign(blocks, 0.0);
    out_.slopes.resize(blocks * width_);
    for (std::size_t i = 0; i < out_.slopes.size(); ++i) out_.slopes[i] = view_.slope_of(static_cast<int>(i));
    out_.wall_inverse.assign(blocks * width_, 0.0);
    std::fill(out_.wall_inverse.begin() + view_.camera.width, out_.wall_inverse.end(), kInfinity);
    out_.wall.assign(blocks * width_, -1);
    out_.wall_face.resize(blocks * width_);
  }

  bool hides_all(const Group& group) const { return group.is_full && view_.is_roofed; }

  // Whether all of a group is beside or behind the picture, or behind walls.
  bool is_hidden(const Group& group) const {
    const Vec2 center = view_.to_camera(group.center);
    const double r = group.radius;
    if (center.x + r <= 0.0) return true;
    Reach reach = all_columns();
    if (center.x - r > kNear) {
      const double left = center.y + r;
      const double right = center.y - r;
      const double s_max = left / (left > 0.0 ? center.x - r : center.x + r);
      const double s_min = right / (right < 0.0 ? center.x - r : center.x + r);
      if (!find_reach(s_min, s_max, center.x - r, reach)) return true;
    }
    return is_behind_walls(reach);
  }

  int block_of(int column) const { return column >> std::countr_zero(width_); }
  Reach all_columns() const { return {0, block_of(view_.camera.width - 1), kInfinity}; }

  bool is_behind_walls(const Reach& reach) const {
    for (int block = reach.first_block; block <= reach.last_block; ++block) {
      if (reach.nearest > out_.farthest[static_cast<std::size_t>(block)]) return false;
    }
    return true;
  }

  // What lies between two slopes; false when it is beside the picture.
  bool find_reach(double s_min, double s_max, double x_min, Reach& reach) const {
    const CameraIntrinsics& camera = view_.camera;
    const double first = camera.cx - camera.fx * s_max - 1.0;
    const double last = camera.cx - camera.fx * s_min + 1.0;
    if (first > camera.width || last < 0.0) return false;
    reach.first_block = block_of(std::min(static_cast<int>(std::max(first, 0.0)), camera.width - 1));
    reach.last_block = block_of(static_cast<int>(std::min(last, camera.width - 1.0)));
    reach.nearest = 1.0 / x_min * (1.0 + 1e-9);
    return true;
  }

  void add_wall(std::size_t i) {
    Candidate& c = out_.walls.emplace_back();
    if (!see(place_.solids[i], place_.sides[i], static_cast<int>(i), c)) out_.walls.pop_back();
  }

  void add_other(const VisibleSolid& visible, const Sides& sides, int solid) {
    Candidate& c = out_.others.emplace_back();
    const bool is_seen = see(visible, sides, solid, c);
    if (!is_seen || is_behind_walls({c.first_block, c.last_block, c.nearest})) {
      out_.others.pop_back();
      return;
    }
    const auto index = static_cast<std::int32_t>(out_.others.size()) - 1;
    for (int block = c.first_block; block <= c.last_block; ++block) {
      const auto b = static_cast<std::size_t>(block);
      if (c.nearest > out_.farthest[b]) out_.blocks[b].push_back({c.nearest, index});
    }
  }

  // Those that come nearest first: most others are then hidden without being met.
  void find_nearest_walls() {
    out_.order.clear();
    for (std::size_t k = 0; k < out_.walls.size(); ++k) {
      out_.order.push_back({out_.walls[k].nearest, static_cast<std::int32_t>(k)});
    }
    std::ranges::sort(out_.order, [](const auto& a, const auto& b) {
      return a.nearest != b.nearest ? a.nearest > b.nearest : a.candidate < b.candidate;
    });
    Intersection intersection;
    for (const Candidates::Entry& entry : out_.order) {
      const Candidate& c = out_.walls[static_cast<std::size_t>(entry.candidate)];
      for (int block = c.first_block; block <= c.last_block; ++block) {
        const auto b = static_cast<std::size_t>(block);
        if (c.nearest <= out_.farthest[b]) continue;
        double* inverse = out_.wall_inverse.data() + b * width_;
        const unsigned met = intersect(c.outline, out_.slopes.data() + b * width_, inverse, intersection);
        if (met == 0) continue;
        for (std::size_t i = 0; i < width_; ++i) {
          if (!(met >> i & 1U)) continue;
          inverse[i] = intersection.near[i];
          out_.wall[b * width_ + i] = entry.candidate;
          out_.wall_face[b * width_ + i] = static_cast<std::int32_t>(intersection.face[i]);
        }
        out_.farthest[b] = *std::min_element(inverse, inverse + width_);
      }
    }
  }

  // Describes a solid as the camera sees it; false when nothing of it can be in the picture.
  bool see(const VisibleSolid& visible, const Sides& sides, int index, Candidate& c) const {
    const Solid& solid = visible.solid;
    const Vec2 center = view_.to_camera(solid.center);
    if (center.x + solid.radius <= 0.0) return false;

    c.visible = &visible;
    c.sides = &sides;
    c.solid = index;
    c.number = out_.walls.size() + out_.others.size() - 1;
    c.low = solid.z_min - view_.height;
    c.high = solid.z_max - view_.height;
    c.outline.is_disc = solid.shape == Solid::Shape::disc;
    const auto corners = corners_of(solid, center);
    if (!find_columns(corners, c)) return false;

    if (c.outline.is_disc) {
      c.outline.center = center;
      c.outline.beyond = dot(center, center) - solid.radius * solid.radius;
    } else {
      add_lines(corners, c.outline);
    }
    const bool within_height = c.low <= 0.0 && c.high > 0.0;
    const bool inside = within_height && (c.outline.is_disc ? c.outline.beyond <= 0.0 : c.outline.near_count == 0);
    return !inside;  // nothing is seen from inside
  }

  // Of a box, or of the square around a disc.
  std::array<Vec2, 4> corners_of(const Solid& solid, Vec2 center) const {
    const double r = solid.radius;
    std::array<Vec2, 4> corners = {center + Vec2{-r, -r}, center + Vec2{r, -r}, center + Vec2{r, r},
                                   center + Vec2{-r, r}};
    if (solid.shape == Solid::Shape::disc) return corners;
    std::ranges::transform(solid.corners, corners.begin(), [&](Vec2 corner) { return view_.to_camera(corner); });
    return corners;
  }

  // The columns between the corners' outermost ones, and how near they come.
  bool find_columns(const std::array<Vec2, 4>& corners, Candidate& c) const {
    const double x_min = std::ranges::min(corners, {}, &Vec2::x).x;
    Reach reach = all_columns();
    if (x_min > kNear) {  // not beside the camera
      double s_min = kInfinity;
      double s_max = -kInfinity;
      for (const Vec2 corner : corners) {
        s_min = std::min(s_min, corner.y / corner.x);
        s_max = std::max(s_max, corner.y / corner.x);
      }
      if (!find_reach(s_min, s_max, x_min, reach)) return false;
    }
    c.first_block = reach.first_block;
    c.last_block = reach.last_block;
    c.nearest = reach.nearest;
    return true;
  }

  // An edge's inner side is where dist * w + (slope of the edge against the ray) >= 0.
  static void add_lines(const std::array<Vec2, 4>& corners, Outline& outline) {
    constexpr double kOnTheLine = 1e-12;
    for (std::size_t i = 0; i < 4; ++i) {
      const Vec2 edge = corners[(i + 1) % 4] - corners[i];
      const double dist = -cross(edge, corners[i]);
      const bool is_near = dist < kOnTheLine;
      const double scale = is_near ? 1.0 / -std::min(dist, -kOnTheLine) : -1.0 / dist;
      auto& line = is_near ? outline.near[static_cast<std::size_t>(outline.near_count++)]
                           : outline.far[static_cast<std::size_t>(outline.far_count++)];
      line = {scale * edge.x, -scale * edge.y, static_cast<double>(i)};
    }
  }

  const Place& place_;
  const View& view_;
  Candidates& out_;
  const std::size_t width_;  // of a block
};

}  // namespace

void find_candidates(const Place& place, const View& view, std::span<const VisibleSolid> moving,
                     Candidates& candidates) {
  Search(place, view, candidates).run(moving);
}

}  // namespace threewe::sim::view
