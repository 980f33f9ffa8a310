// The numbers by which columns of pixels draw what they show.
#include <algorithm>
#include <cmath>

#include "sim/renderer/columns.hpp"
#include "sim/renderer/textures.hpp"

namespace threewe::sim::view {
namespace {

void fill_look(Span& span, const Look& look) {
  span.colour = look.colour;
  span.dark = look.dark;
  span.contrast = look.contrast;
  span.shade = look.shade;
  span.shade_rise = look.shade_rise;
  span.material = look.material;
}

struct Level {
  Vec2 origin{};
  Vec2 axis{1.0, 0.0};
  double height = 0.0;  // [m] above the eye
};

// A level surface, with its texture along `axis` from `origin`.
void fill_flat(Span& span, const Look& look, const Level& level, const View& view, Vec2 direction) {
  constexpr double kPixel = 0.35;  // the size of a pixel on the surface, against its length: it is narrow and long
  span.way = Way::level;
  fill_look(span, look);
  const double per_metre = 1.0 / spec(look.material).tile_size;
  const Vec2 across{-level.axis.y, level.axis.x};
  const Vec2 from = view.eye - level.origin;
  span.u = static_cast<float>(per_metre * dot(from, level.axis));
  span.u_step = static_cast<float>(per_metre * dot(direction, level.axis));
  span.v = static_cast<float>(per_metre * dot(from, across));
  span.v_step = static_cast<float>(per_metre * dot(direction, across));
  const double footprint = kPixel / (view.camera.fy * std::fabs(level.height));  // at depth 1
  span.footprint = static_cast<float>(footprint * kTileSide * per_metre);
}

// A floor is lit by where it is.
void fill_floor(Span& span, const Look& look, const FloorLight& light, const View& view, Vec2 direction) {
  constexpr double kPerMetre = 256.0 / FloorLight::kCell;
  fill_flat(span, look, {.height = -view.height}, view, direction);
  span.way = Way::floor;
  span.id = kFloorId;
  span.light_x = static_cast<float>(kPerMetre * (view.eye.x - light.origin.x));
  span.light_y = static_cast<float>(kPerMetre * (view.eye.y - light.origin.y));
  span.light_x_step = static_cast<float>(kPerMetre * direction.x);
  span.light_y_step = static_cast<float>(kPerMetre * direction.y);
}

// Clouds at their height, and the sun's glow.
void fill_sky(Span& span, const View& view, Vec2 direction) {
  fill_flat(span, cloud_look(), {.height = kCloudHeight}, view, direction);
  span.way = Way::sky;
  span.inverse_rise = static_cast<float>(1.0 / kCloudHeight);
  span.glow = sun_share(direction);
}

void fill_hills(Span& span, Vec2 direction) {
  const Look look = hill_look();
  fill_look(span, look);
  span.way = Way::sky;
  span.inverse = 1.0F;  // any
  span.glow = sun_share(direction);
}

// The top or the bottom of a solid, its texture along its longer side.
void fill_face(Span& span, const Run& run, const View& view, Vec2 direction) {
  const Candidate& c = *run.candidate;
  const bool is_top = run.kind == Run::Kind::top;
  const Look look = is_top ? top_look(*c.visible, c.colour) : bottom_look(*c.visible, c.colour);
  const Side& a = (*c.sides)[0];
  const Side& b = (*c.sides)[3];
  const Vec2 axis = c.outline.is_disc ? Vec2{1.0, 0.0} : a.length >= b.length ? a.axis : -1.0 * b.axis;
  fill_flat(span, look, {c.visible->solid.center, axis, is_top ? c.high : c.low}, view, direction);
  span.id = c.visible->id;
}

// An upright surface where a ray meets it.
void fill_side(Span& span, const Run& run, const Place& place, const View& view, Vec2 direction) {
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
  fill_look(span, look);
  span.way = Way::upright;
  const double per_metre = 1.0 / spec(look.material).tile_size;
  span.u = static_cast<float>(per_metre * along);
  span.v = static_cast<float>(per_metre * height);
  span.v_step = static_cast<float>(per_metre);
  constexpr double kPixel = 0.7;
  const double facing = -dot(direction, side.normal) / norm(direction);
  const double footprint = kPixel * depth / view.camera.fx / std::max(facing, 0.35);
  span.footprint = static_cast<float>(footprint * kTileSide * per_metre);
  span.id = c.visible->id;
}

}  // namespace

void fill(const Run& run, const Place& place, const View& view, double s, Span& span) {
  span.inverse = run.inverse.at_horizon;
  span.inverse_rise = run.inverse.rise;
  const Vec2 direction = view.direction(s);
  switch (run.kind) {
    case Run::Kind::nothing: span.way = Way::sky; break;
    case Run::Kind::sky: fill_sky(span, view, direction); break;
    case Run::Kind::hills: fill_hills(span, direction); break;
    case Run::Kind::ceiling:
      fill_flat(span, place.ceiling_look, {.height = place.ceiling - view.height}, view, direction);
      span.id = kCeilingId;
      break;
    case Run::Kind::floor:
      fill_floor(span, run.floor ? run.floor->floor : place.outside_floor, place.light, view, direction);
      break;
    case Run::Kind::side:
    case Run::Kind::skirting:
    case Run::Kind::decor: fill_side(span, run, place, view, direction); break;
    case Run::Kind::top:
    case Run::Kind::bottom: fill_face(span, run, view, direction); break;
  }
}

}  // namespace threewe::sim::view
