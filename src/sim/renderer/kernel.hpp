// The inner part of the renderer: columns of pixels, each from the surfaces that it shows, vectorised.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/renderer/light.hpp"
#include "sim/renderer/textures.hpp"

namespace threewe::sim::view {

/// The ways to draw a surface: upright, at one depth all the way down; level; the floor, which is level and has a light
/// of its own; the sky and what covers it.
enum class Way : std::uint8_t { upright, level, floor, sky };

/// A stretch of rows in which a column shows one surface, as numbers that its pixels are computed with. With t the
/// slope of a row, z / x:
///   inverse depth      w = inverse + inverse_rise * t
///   texture [tiles]    u = u + u_step / w,  v = v + v_step / w; upright: v = v + v_step * t / w
///   texels per pixel   footprint / w^2; upright: footprint
///   colour             (b, g, r) * (dark + contrast * brightness) * light
///   light              upright: min(1, shade + shade_rise * v); level: 1; floor: that at light + light_step / w
/// Before the sky, colour covers dark + contrast * brightness of it, and the sun adds `glow` of its own.
struct Span {
  std::int32_t column = 0;  // in the strip
  std::int32_t begin = 0;   // rows
  std::int32_t end = 0;
  Way way{};
  std::int16_t id = kNothingId;
  float inverse = 0.0F;
  float inverse_rise = 0.0F;
  float u = 0.0F;
  float u_step = 0.0F;
  float v = 0.0F;
  float v_step = 0.0F;
  float footprint = 0.0F;
  Material material{};
  Colour colour;
  float dark = 0.0F;
  float contrast = 0.0F;
  float shade = 0.0F;
  float shade_rise = 0.0F;
  float glow = 0.0F;
  float light_x = 0.0F;  // [1/256 cells]
  float light_y = 0.0F;
  float light_x_step = 0.0F;
  float light_y_step = 0.0F;
};

/// Pixels are drawn by so many at most at a time, also beyond the end of a span: arrays by row have that much to spare.
inline constexpr int kMostLanes = 16;

/// What is the same all along the rows of a picture.
struct Rows {
  int count = 0;
  std::vector<float> slopes;               // t
  std::vector<float> floor;                // how far away it is [m]
  std::vector<float> haze;                 // how much of the floor it hides; empty where there is none
  std::array<std::vector<float>, 3> sky;   // blue, green, red
  std::array<std::vector<float>, 3> glow;  // what the sun adds to it
};

/// A picture is drawn in strips of this many columns, so that what is drawn stays close at hand.
inline constexpr int kStripWidth = 64;

/// What is looked up in a table of 2x2 bytes a cell: the cells, then the words found there, and the places within them.
struct Lookups {
  std::vector<std::uint32_t> cells;
  std::vector<std::uint32_t> x;
  std::vector<std::uint32_t> y;
};

/// What floors of one material have in common, by row: the level of the texture, known by its side and its first line
/// [1/256 texels].
struct FloorRows {
  bool is_known = false;
  std::vector<float> side;
  std::vector<float> first;
};

/// Working memory of a strip: columns of pixels, and what one column takes to be drawn.
struct Strip {
  std::size_t pitch = 0;  // from one column to the next
  std::vector<std::uint32_t> colour;
  std::vector<float> depth;
  std::vector<std::int16_t> ids;
  Lookups texture;
  Lookups light;
  std::array<FloorRows, kMaterials> floors;
};

/// Where the pixels of a strip go, from its first; null where an image is left out.
struct Target {
  std::uint8_t* colour = nullptr;
  float* depth = nullptr;
  std::int16_t* ids = nullptr;
  std::size_t width = 0;  // from one row to the next [px]
  std::size_t columns = 0;
};

/// Begins a picture of so many rows.
void begin_strips(int rows, Strip& strip);
/// Draws a strip. Spans go from column to column, and in each from top to bottom without a gap.
void draw_strip(std::span<const Span> spans, const Rows& rows, const FloorLight& light, Strip& strip,
                const Target& target);

}  // namespace threewe::sim::view
