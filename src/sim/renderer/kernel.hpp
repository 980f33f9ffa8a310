// The inner part of the renderer: blocks of a few columns at a time, vectorised across them.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/aligned_vector.hpp"
#include "sim/renderer/candidates.hpp"
#include "sim/renderer/textures.hpp"

namespace threewe::sim::view {

/// What is the same all along the rows of a picture. With t the slope of a row, z / x.
struct Rows {
  int count = 0;
  int level = -1;              // the row that looks exactly along the horizon, if any
  std::vector<float> slopes;   // t
  std::vector<float> inverse;  // 1 / t
  std::vector<float> above;    // depth of the ceiling [m]; infinity above and beyond it
  std::vector<float> below;    // depth of the floor [m]
  // under the sky, else empty
  std::vector<float> haze;                 // how much of the floor it hides
  std::array<std::vector<float>, 3> sky;   // blue, green, red
  std::array<std::vector<float>, 3> glow;  // what the sun adds to it
};

/// How a level surface takes its texture, by row: in texels of the level that suits the row
///   u = (u_step of the column) * scale + u,  v likewise,
/// each within `mask`, and the texel is first + u * stride + v.
struct LevelRows {
  bool is_known = false;
  std::vector<float> scale;
  std::vector<float> u;
  std::vector<float> v;
  std::vector<std::uint32_t> mask;
  std::vector<std::uint32_t> stride;
  std::vector<std::uint32_t> first;
};

/// An array over the columns of a block.
template <class T>
struct alignas(64) Lanes : std::array<T, kWidestBlock> {};

/// A surface that may be seen in a block. Those that stand are at one depth all the way down a column.
struct Surface {
  enum class Kind : std::uint8_t { side, skirting, decor, top, bottom };
  Kind kind{};
  bool is_ready = false;
  const Candidate* candidate = nullptr;
  const Decor* decor = nullptr;
  Lanes<float> depth;  // where it stands
  Lanes<float> face;

  // once it is ready: in row t an upright surface shows texel line + (v + v_step * t, within mask),
  // and light min(1, foot + rise * t), in 1/170
  Lanes<std::uint32_t> line;
  Lanes<std::uint32_t> mask;
  Lanes<std::uint32_t> tint;
  Lanes<float> v;
  Lanes<float> v_step;
  Lanes<float> foot;
  Lanes<float> rise;
};

/// Colours are made for so many rows at a time, so that what they are made of stays close at hand.
inline constexpr std::size_t kBand = 64;

/// Working memory of a block: by row, and in each by column.
struct BlockWork {
  AlignedVector<float> depth;         // [m]; infinity where there is nothing
  AlignedVector<std::int32_t> owner;  // who is seen

  std::vector<std::int16_t> ids;  // by owner

  // of a band
  AlignedVector<std::uint32_t> texel;   // place in `tiles`, then what is found there
  AlignedVector<std::uint32_t> light;   // in 1/170
  AlignedVector<std::uint32_t> tint;    // blue, green, red, before texture and light
  AlignedVector<std::uint32_t> veil;    // the same, added; only under the sky
  AlignedVector<std::uint32_t> cell;    // of the floor's light
  AlignedVector<std::uint32_t> within;  // the place in it

  std::vector<Surface> surfaces;
  std::size_t surface_count = 0;
  std::array<LevelRows, kMaterials> floors;                  // known for the whole picture
  std::array<std::optional<Material>, kMaterials> patterns;  // what surfaces wear, once that is asked
  std::vector<std::optional<Colour>> colours;                // of candidates, likewise
  LevelRows others;
};

/// The detail of a picture in 1/256.
inline constexpr std::uint32_t kWhole = 256;
inline std::uint32_t detail_of(const Shading& shading) {
  return static_cast<std::uint32_t>(std::lround(shading.detail * static_cast<float>(kWhole)));
}
/// A brightness b [1/170] is (b * detail + this) / 256 in a picture of less detail: nearer to 1.
constexpr std::uint32_t plain_of(std::uint32_t detail) {
  return static_cast<std::uint32_t>(kTexelOne) * (kWhole - detail) + kWhole / 2;
}

/// All that a picture is drawn from.
struct Drawing {
  const Place& place;
  const View& view;
  const Rows& rows;
  const Candidates& candidates;
  const Shading& shading;
  const Images& images;
};

void draw(const Drawing& drawing, BlockWork& work);

}  // namespace threewe::sim::view
