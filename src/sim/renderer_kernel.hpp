// The inner part of the renderer: one row of pixels, each from what its column shows there, vectorised.
#pragma once

#include <array>
#include <cstdint>

#include "sim/renderer_place.hpp"

namespace threewe::sim::view {

/// What a column shows in some rows, as numbers that a row of pixels computes with. With t the slope of the row, z / x:
///   inverse depth      w = inverse + inverse_rise * t
///   texture [tiles]    u = u + u_step / w,  v = v + (v_step + v_rise * t) / w
///   texels per pixel   footprint + footprint_rise / w^2
///   colour             (b, g, r) * (dark + contrast * brightness) * min(1, shade + shade_rise * v)
/// Where the id is 0, colour covers dark + contrast * brightness of the sky, to which the sun adds `glow` of its own.
enum Field : std::uint8_t {
  kInverse,
  kInverseRise,
  kU,
  kUStep,
  kV,
  kVStep,
  kVRise,
  kFootprint,
  kFootprintRise,
  kBlue,
  kGreen,
  kRed,
  kDark,
  kContrast,
  kShade,
  kShadeRise,
  kGlow,
  kTile,  // the first row of the material's tile
  kId,
  kFieldCount,
};
using Fields = std::array<float, kFieldCount>;

/// A picture is drawn in strips of this many columns, so that all that a row needs stays close at hand.
inline constexpr int kStripWidth = 128;

/// A part of a row of pixels: what each of its columns shows there. Fields of columns beyond the picture are 0.
struct Row {
  alignas(64) std::array<std::array<float, kStripWidth>, kFieldCount> fields;
  alignas(
      64) std::array<float, kStripWidth> x_steps;  // world direction of each column, for depth 1 [floor light cells]
  alignas(64) std::array<float, kStripWidth> y_steps;
  int lanes = 0;       // how many of the columns to draw, rounded up to whole vectors
  float eye_x = 0.0F;  // relative to the floor's light [cells]
  float eye_y = 0.0F;
  float slope = 0.0F;  // t
  float haze = 0.0F;   // how much of the floor the horizon hides
};
/// Columns are drawn in whole multiples of this.
inline constexpr int kMostLanes = 16;

/// Where pixels go; null where an image is left out. Room for `Row::lanes` each.
struct RowImages {
  std::uint8_t* colour = nullptr;
  float* depth = nullptr;
  std::int16_t* ids = nullptr;
};

void draw_row(const Row& row, const FloorLight& light, const RowImages& images);

}  // namespace threewe::sim::view
