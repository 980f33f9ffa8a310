// The numbers by which rows of pixels draw what a column shows.
#include <algorithm>
#include <cmath>

#include "sim/renderer_columns.hpp"
#include "sim/renderer_textures.hpp"

namespace threewe::sim::view {
namespace {

void fill_look(Fields& f, const Look& look) {
  f[kBlue] = look.colour.b;
  f[kGreen] = look.colour.g;
  f[kRed] = look.colour.r;
  f[kDark] = look.dark;
  f[kContrast] = look.contrast;
  f[kShade] = look.shade;
  f[kShadeRise] = look.shade_rise;
  f[kTile] = static_cast<float>(static_cast<int>(look.material) * kTileRows);
}

struct Level {
  Vec2 origin{};
  Vec2 axis{1.0, 0.0};
  double height = 0.0;  // [m] above the eye
};

// A level surface, with its texture along `axis` from `origin`.
void fill_flat(Fields& f, const Look& look, const Level& level, const View& view, Vec2 direction) {
  constexpr double kPixel = 0.35;  // the size of a pixel on the surface, against its length: it is narrow and long
  fill_look(f, look);
  const double per_metre = 1.0 / spec(look.material).tile_size;
  const Vec2 across{-level.axis.y, level.axis.x};
  const Vec2 from = view.eye - level.origin;
  f[kU] = static_cast<float>(per_metre * dot(from, level.axis));
  f[kUStep] = static_cast<float>(per_metre * dot(direction, level.axis));
  f[kV] = static_cast<float>(per_metre * dot(from, across));
  f[kVStep] = static_cast<float>(per_metre * dot(direction, across));
  const double footprint = kPixel / (view.camera.fy * std::fabs(level.height));  // at depth 1
  f[kFootprintRise] = static_cast<float>(footprint * kTileSide * per_metre);
}

// Clouds at their height, and the sun's glow.
void fill_sky(Fields& f, const View& view, Vec2 direction) {
  fill_flat(f, cloud_look(), {.height = kCloudHeight}, view, direction);
  f[kInverseRise] = static_cast<float>(1.0 / kCloudHeight);
  f[kGlow] = sun_share(direction);
}

void fill_hills(Fields& f, Vec2 direction) {
  const Look look = hill_look();
  fill_look(f, look);
  f[kInverse] = 1.0F;  // any
  f[kGlow] = sun_share(direction);
}

// The top or the bottom of a solid, its texture along its longer side.
void fill_face(Fields& f, const Run& run, const View& view, Vec2 direction) {
  const Candidate& c = *run.candidate;
  const bool is_top = run.kind == Run::Kind::top;
  const Look look = is_top ? top_look(*c.visible, c.colour) : bottom_look(*c.visible, c.colour);
  const Side& a = (*c.sides)[0];
  const Side& b = (*c.sides)[3];
  const Vec2 axis = c.outline.is_disc ? Vec2{1.0, 0.0} : a.length >= b.length ? a.axis : -1.0 * b.axis;
  fill_flat(f, look, {c.visible->solid.center, axis, is_top ? c.high : c.low}, view, direction);
  f[kId] = static_cast<float>(c.visible->id);
}

// An upright surface where a ray meets it.
void fill_side(Fields& f, const Run& run, const Place& place, const View& view, Vec2 direction) {
  const Candidate& c = *run.candidate;
  const double depth = 1.0 / run.near;
  const Vec2 hit = view.eye + depth * direction;
  const Sides& sides = *c.sides;
  const bool is_disc = c.outline.is_disc;
  const Side side = is_disc ? round_side(*c.visible, sides[0].look, hit) : sides[static_cast<std::size_t>(run.face)];
  double along = is_disc ? c.visible->solid.radius * exact::atan2(side.normal.y, side.normal.x)
                         : dot(hit - side.corner, side.axis);
  double height = view.height;
  Look look = side.look;
  look.colour = c.colour;
  if (run.decor) {
    look = run.decor->look;
    along -= run.decor->begin;
    height -= run.decor->low;
  } else if (run.kind == Run::Kind::skirting) {
    look = skirting_look(side.normal);
  } else if (c.visible->id == kWallId && !is_disc) {
    look.colour = place.wall_colour(*c.visible, side, hit);
  }
  fill_look(f, look);
  const double per_metre = 1.0 / spec(look.material).tile_size;
  f[kU] = static_cast<float>(per_metre * along);
  f[kV] = static_cast<float>(per_metre * height);
  f[kVRise] = static_cast<float>(per_metre);
  constexpr double kPixel = 0.7;
  const double facing = -dot(direction, side.normal) / norm(direction);
  const double footprint = kPixel * depth / view.camera.fx / std::max(facing, 0.35);
  f[kFootprint] = static_cast<float>(footprint * kTileSide * per_metre);
  f[kId] = static_cast<float>(c.visible->id);
}

}  // namespace

void fill(const Run& run, const Place& place, const View& view, double s, Fields& f) {
  f[kInverse] = run.inverse.at_horizon;
  f[kInverseRise] = run.inverse.rise;
  const Vec2 direction = view.direction(s);
  switch (run.kind) {
    case Run::Kind::nothing: break;
    case Run::Kind::sky: fill_sky(f, view, direction); break;
    case Run::Kind::hills: fill_hills(f, direction); break;
    case Run::Kind::ceiling:
      fill_flat(f, place.ceiling_look, {.height = place.ceiling - view.height}, view, direction);
      f[kId] = kCeilingId;
      break;
    case Run::Kind::floor:
      fill_flat(f, run.floor ? run.floor->floor : place.outside_floor, {.height = -view.height}, view, direction);
      f[kId] = kFloorId;
      break;
    case Run::Kind::side:
    case Run::Kind::skirting:
    case Run::Kind::decor: fill_side(f, run, place, view, direction); break;
    case Run::Kind::top:
    case Run::Kind::bottom: fill_face(f, run, view, direction); break;
  }
}

}  // namespace threewe::sim::view
