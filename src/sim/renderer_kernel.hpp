// The inner part of the renderer: one row of pixels, each from what its column shows there, vectorised.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sim/renderer_place.hpp"

namespace threewe::sim::view {

/// What a column shows in some rows, as numbers that a row of pixels computes with. With t the slope of the row, z / x:
///   inverse depth      w = inverse + inverse_rise * t
///   texture [tiles]    u = u + u_step / w,  v = v + (v_step + v_rise * t) / w
///   texels per pixel   footprint + footprint_rise / w^2
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
  kDarkB,
  kDarkG,
  kDarkR,
  kContrastB,
  kContrastG,
  kContrastR,
  kShade,
  kShadeRise,
  kTile,  // where the material's tile begins
  kId,
  kIsFloor,  // 1: lit by `FloorLight`
  kFieldCount,
};
using Fields = std::array<float, kFieldCount>;

/// Rows of pixels are worked on in vectors of up to this many.
inline constexpr int kMostLanes = 16;

/// The state of every column at the row that is being drawn.
struct Row {
  int width = 0;
  int stride = 0;              ///< `width` rounded up to whole vectors: from one field to the next
  std::vector<float> fields;   ///< (kFieldCount, stride)
  std::vector<float> x_steps;  ///< (stride), world direction of each column, for depth 1
  std::vector<float> y_steps;
  float eye_x = 0.0F;  ///< relative to the floor's light [cells]
  float eye_y = 0.0F;
  float slope = 0.0F;  ///< t
};

/// Where a row goes; null where it is left out. Room for `Row::stride` pixels each.
struct RowImages {
  std::uint8_t* colour = nullptr;
  float* depth = nullptr;
  std::int16_t* ids = nullptr;
};

void draw_row(const Row& row, const FloorLight& light, const RowImages& images);

}  // namespace threewe::sim::view
