// The renderer's slow, obvious twin: every pixel is one ray in space that is tried against every solid.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "sim/renderer.hpp"
#include "sim/renderer/place.hpp"
#include "sim/renderer/textures.hpp"

namespace threewe::sim {

/// What a ray meets first.
struct Hit {
  double depth = std::numeric_limits<double>::infinity();  ///< [m] along the optical axis
  std::int16_t id = kNothingId;
  int solid = -1;
  int face = -1;
};

class RayTracer {
 public:
  RayTracer(const scene::Scene& scene, const CameraIntrinsics& camera, const CameraPose& view, const Shading& shading,
            std::vector<VisibleSolid> moving = {})
      : place_(scene), solids_(place_.solids), camera_(camera), view_(view), shading_(shading) {
    solids_.insert(solids_.end(), moving.begin(), moving.end());
  }

  /// The ray through image coordinates (u, v), as slopes: y / x and z / x.
  Hit cast(double u, double v) const {
    const double s = (camera_.cx - u) / camera_.fx;
    const double t = (camera_.cy - v) / camera_.fy;
    const Vec2 direction = this->direction(s);
    Hit hit;
    const auto intersect = [&](double depth, std::int16_t id, int solid, int face) {
      if (depth > 0.0 && depth < hit.depth) hit = {depth, id, solid, face};
    };
    if (t < 0.0) intersect(-view_.height / t, kFloorId, -1, view::kTopFace);
    if (t > 0.0 && view_.height < place_.ceiling && place_.ceiling < 1e9) {
      intersect((place_.ceiling - view_.height) / t, kCeilingId, -1, view::kBottomFace);
    }
    for (std::size_t i = 0; i < solids_.size(); ++i) {
      const auto [depth, face] = enter(solids_[i].solid, direction, t);
      intersect(depth, solids_[i].id, static_cast<int>(i), face);
    }
    return hit;
  }

  /// The colour of what a ray meets: its look, its texture interpolated on the level that suits the pixel, its shade.
  /// `off` takes a level above or below, and the texel a little farther.
  struct Off {
    int level = 0;
    Vec2 texel{};
  };
  Colour colour(double u, double v, const Hit& hit, const Off& off) const {
    const Colour seen = light_of(u, v, hit, off);
    const auto channel = [](float value, float gain) { return std::clamp(value * gain, 0.0F, 255.0F); };
    return {channel(seen.b, shading_.gain.b), channel(seen.g, shading_.gain.g), channel(seen.r, shading_.gain.r)};
  }

 private:
  Colour light_of(double u, double v, const Hit& hit, const Off& off) const {
    const double t = (camera_.cy - v) / camera_.fy;
    const Vec2 direction = this->direction((camera_.cx - u) / camera_.fx);
    if (hit.id == kNothingId) return sky(direction, t, off);
    const Vec2 point = view_.pose.position() + hit.depth * direction;
    const double z = view_.height + hit.depth * t;

    if (hit.id == kFloorId) {
      const auto* floor = place_.floor_at(point);
      const view::SurfaceMaterial look = floor ? floor->floor : place_.outside_floor;
      const Colour bare =
          apply(look, texture(look, point, flat_footprint(hit.depth, view_.height), off), place_.light.at(point));
      if (!place_.is_open) return bare;
      return mixed(bare, view::sky_colour(0.0F), view::haze(view_.height, static_cast<float>(t)));
    }
    if (hit.id == kCeilingId) {
      const double footprint = flat_footprint(hit.depth, place_.ceiling - view_.height);
      return apply(place_.ceiling_material, texture(place_.ceiling_material, point, footprint, off), 1.0);
    }

    const VisibleSolid& visible = solids_[static_cast<std::size_t>(hit.solid)];
    const scene::Solid& solid = visible.solid;
    const auto index = static_cast<std::size_t>(hit.solid);
    const bool stands = index < place_.solids.size();
    const Colour own = stands ? place_.colour(shading_, index) : visible.colour;
    if (hit.face == view::kTopFace || hit.face == view::kBottomFace) {
      const bool is_top = hit.face == view::kTopFace;
      const view::SurfaceMaterial look =
          is_top ? view::top_material(visible, own) : view::bottom_material(visible, own);
      const double height = std::fabs((is_top ? solid.z_max : solid.z_min) - view_.height);
      Vec2 axis{1.0, 0.0};
      if (solid.shape == scene::Solid::Shape::box) {
        const Vec2 a = solid.corners[1] - solid.corners[0];
        const Vec2 b = solid.corners[3] - solid.corners[0];
        axis = norm(a) >= norm(b) ? (1.0 / norm(a)) * a : (1.0 / norm(b)) * b;
      }
      const Vec2 local{dot(point - solid.center, axis), dot(point - solid.center, {-axis.y, axis.x})};
      return apply(look, texture(look, local, flat_footprint(hit.depth, height), off), 1.0);
    }

    const view::Sides sides = view::make_sides(visible, place_.is_open);
    const bool is_round = hit.face == view::kRoundFace;
    const view::Side side =
        is_round ? view::round_side(visible, sides[0].look, point) : sides[static_cast<std::size_t>(hit.face)];
    const Vec2 normal = side.normal;
    const double along = is_round ? view::along_round(solid.radius, normal) : dot(point - side.corner, side.axis);
    view::SurfaceMaterial look = side.look;
    look.colour = own;
    if (visible.id == kWallId && !is_round) {
      const auto tints = place_.tints_of(index, static_cast<std::size_t>(hit.face));
      const auto bin = static_cast<std::size_t>(std::max(along / view::kTintStep, 0.0));
      const Colour painted = unpacked(tints[std::min(bin, tints.size() - 1)]);
      const Colour plain = place_.plain_wall();
      const Colour lit{look.light * plain.b, look.light * plain.g, look.light * plain.r};
      look.colour = mixed(lit, painted, shading_.detail);
      look.light = 1.0F;
    }
    const bool is_detailed = shading_.detail >= view::kSkirtingDetail;
    if (place_.has_skirting(visible) && is_detailed && z < view::kSkirting) look = view::skirting_material(normal);
    Vec2 on_face{along, z};
    for (const view::Decor& d : place_.decor_of(stands ? hit.solid : -1)) {
      if (shading_.detail < d.detail || d.face != hit.face || along < d.begin || along >= d.end || z < d.low ||
          z >= d.high)
        continue;
      look = d.look;
      on_face = {along - d.begin, z - d.low};
    }
    const double facing = -dot(direction, normal) / norm(direction);
    const double footprint = 0.7 * hit.depth / camera_.fx / std::max(facing, 0.35);
    const double shade = static_cast<double>(look.foot) + static_cast<double>(look.rise) * z;
    return apply(look, texture(look, on_face, footprint, off), std::min(1.0, shade));
  }

  Vec2 direction(double s) const {
    const Vec2 forward{std::cos(view_.pose.theta), std::sin(view_.pose.theta)};
    return forward + s * Vec2{-forward.y, forward.x};
  }

  // Clouds and hills before a sky that the sun brightens.
  Colour sky(Vec2 direction, double t, const Off& off) const {
    const auto slope = static_cast<float>(t);
    const Colour blue = view::sky_colour(slope);
    if (t <= 0.0) return blue;
    const float share = view::sun_share(direction);
    const Colour sun = view::sun_glow(slope);
    const Colour lit{blue.b + share * sun.b, blue.g + share * sun.g, blue.r + share * sun.r};
    const bool is_hill = place_.is_open && t < view::hill_slope(direction);
    if (is_hill) return mixed(lit, view::kHills, view::kHillCover);
    const view::SurfaceMaterial look = view::cloud_material();
    const double depth = view::kCloudHeight / t;
    const Vec2 point = view_.pose.position() + depth * direction;
    const double cover = texture(look, point, flat_footprint(depth, view::kCloudHeight), off);
    return mixed(lit, look.colour, static_cast<float>(cover));
  }

  static Colour unpacked(std::uint32_t word) {
    const auto byte = [&](unsigned k) { return static_cast<float>(word >> (8U * k) & 255U); };
    return {byte(0), byte(1), byte(2)};
  }

  static Colour mixed(Colour a, Colour b, float share) {
    const auto channel = [&](float from, float to) { return from + share * (to - from); };
    return {channel(a.b, b.b), channel(a.g, b.g), channel(a.r, b.r)};
  }

  struct Entry {
    double depth;
    int face;
  };

  // Where a ray enters a solid from outside, and by which face.
  Entry enter(const scene::Solid& solid, Vec2 direction, double t) const {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    Entry entry{-kInfinity, -1};
    double leave = kInfinity;
    const auto half_space = [&](double outside, double speed, int face) {  // outside + depth * speed <= 0 is inside
      if (speed == 0.0) {
        if (outside > 0.0) leave = -kInfinity;
      } else if (speed < 0.0) {
        if (-outside / speed > entry.depth) entry = {-outside / speed, face};
      } else {
        leave = std::min(leave, -outside / speed);
      }
    };
    half_space(view_.height - solid.z_max, t, view::kTopFace);
    half_space(solid.z_min - view_.height, -t, view::kBottomFace);
    const Vec2 eye = view_.pose.position();
    if (solid.shape == scene::Solid::Shape::box) {
      for (int i = 0; i < 4; ++i) {
        const Vec2 a = solid.corners[static_cast<std::size_t>(i)];
        const Vec2 edge = solid.corners[static_cast<std::size_t>((i + 1) % 4)] - a;
        const Vec2 outward{edge.y, -edge.x};
        half_space(dot(outward, eye - a), dot(outward, direction), i);
      }
    } else {
      const Vec2 from = eye - solid.center;
      const double a = dot(direction, direction);
      const double b = dot(direction, from);
      const double c = dot(from, from) - solid.radius * solid.radius;
      const double root = b * b - a * c;
      if (root < 0.0) return {-1.0, -1};
      if ((-b - std::sqrt(root)) / a > entry.depth) entry = {(-b - std::sqrt(root)) / a, view::kRoundFace};
      leave = std::min(leave, (-b + std::sqrt(root)) / a);
    }
    return entry.depth < leave ? entry : Entry{-1.0, -1};
  }

  double flat_footprint(double depth, double height) const {
    return depth * depth * 0.35 / (camera_.fy * std::fabs(height));
  }

  double texture(const view::SurfaceMaterial& look, Vec2 point, double footprint, const Off& off) const {
    const Material pattern = view::patterns_of(shading_.texture)[static_cast<std::size_t>(look.material)];
    const double size = view::spec(pattern).tile_size;
    const double texels = footprint * view::kTileSide / size;
    const int level = texels < 1.0 ? 0 : std::min(static_cast<int>(std::log2(texels)), view::kTileLevels - 1);
    const int shifted = std::clamp(level + off.level, 0, view::kTileLevels - 1);
    const Vec2 shift = (1.0 / (view::kTileSide >> shifted)) * off.texel;
    return view::sample(pattern, shifted, point.x / size + shift.x, point.y / size + shift.y);
  }

  Colour apply(const view::SurfaceMaterial& look, double brightness, double shade) const {
    const auto nearer_one = [&](double x) { return 1.0 + static_cast<double>(shading_.detail) * (x - 1.0); };
    const float light = look.light * static_cast<float>(nearer_one(shade) * nearer_one(brightness));
    const auto channel = [&](float own) { return own * light; };
    return {channel(look.colour.b), channel(look.colour.g), channel(look.colour.r)};
  }

  view::Place place_;
  std::vector<VisibleSolid> solids_;
  CameraIntrinsics camera_;
  CameraPose view_;
  Shading shading_;
};

}  // namespace threewe::sim
