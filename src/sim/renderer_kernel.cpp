// How a row of pixels gets its depth, ids and colour. All products are unfused and all quotients exact, so that the
// bits are the same for every target.
#include "sim/renderer_kernel.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "sim/renderer_textures.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sim/renderer_kernel.cpp"
#include "threewe/core/highway-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace threewe::sim::view::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, kMostLanes>;
using Ints = hn::RebindToSigned<Floats>;
using Shorts = hn::Rebind<std::int16_t, Floats>;
using Words = hn::RebindToUnsigned<Floats>;
using F = hn::Vec<Floats>;
using W = hn::Vec<Words>;

// Adding this to a number in [0, 2^22) leaves the nearest whole number in the low bits: one operation, where converting
// takes several that guard against overflow.
constexpr float kRounder = 8388608.0F;
constexpr std::uint32_t kRounderBits = 0x4B000000U;

HWY_INLINE W rounded(F x) {
  const Floats d;
  return hn::BitCast(Words(), hn::Add(x, hn::Set(d, kRounder)));
}

// Interpolates between the four bytes of a cell by the low 8 bits of x and y, in 1/65536. Two bytes at a time share a
// word.
HWY_INLINE F interpolate(W cell, W x, W y) {
  const Floats d;
  const Words dw;
  const Ints di;
  const W two_bytes = hn::Set(dw, 0x00FF00FFU);
  const W one = hn::Set(dw, 256U);
  const W weight_x = hn::And(x, hn::Set(dw, 255U));
  const W weight_y = hn::And(y, hn::Set(dw, 255U));
  const W left = hn::And(cell, two_bytes);
  const W right = hn::And(hn::ShiftRight<8>(cell), two_bytes);
  const W both = hn::Add(hn::Mul(left, hn::Sub(one, weight_x)), hn::Mul(right, weight_x));
  const W low = hn::And(both, hn::Set(dw, 0xFFFFU));
  const W high = hn::ShiftRight<16>(both);
  const W sum = hn::Add(hn::Mul(low, hn::Sub(one, weight_y)), hn::Mul(high, weight_y));
  return hn::ConvertTo(d, hn::BitCast(di, sum));
}

// 256 times the number of texels across the level that suits a footprint [texels of level 0]: a power of two, made
// from the exponent.
HWY_INLINE F level_side(F footprint) {
  const Floats d;
  const Words dw;
  constexpr std::uint32_t kOne = 127U << 23U;
  constexpr std::uint32_t kCoarsest = (127U + kTileLevels - 1U) << 23U;
  constexpr std::uint32_t kProduct = (127U + 127U + 15U) << 23U;  // 2^e times 2^(15 - e)
  const W power = hn::And(hn::BitCast(dw, footprint), hn::Set(dw, 0x7F800000U));
  const W within = hn::Min(hn::Max(power, hn::Set(dw, kOne)), hn::Set(dw, kCoarsest));
  return hn::BitCast(d, hn::Sub(hn::Set(dw, kProduct), within));
}

// What is looked up in a table of 2x2 bytes a cell, for a strip of pixels: the cells, then the words found there, and
// the places within them.
struct Lookups {
  HWY_ALIGN std::uint32_t cells[kStripWidth];
  HWY_ALIGN std::uint32_t x[kStripWidth];
  HWY_ALIGN std::uint32_t y[kStripWidth];

  HWY_INLINE void set(std::size_t i, W cell, W at_x, W at_y) {
    const Words dw;
    hn::Store(cell, dw, cells + i);
    hn::Store(at_x, dw, x + i);
    hn::Store(at_y, dw, y + i);
  }
  // One by one: the gather of AVX2 is slower on the machines that it was measured on.
  HWY_INLINE void find(const std::uint32_t* HWY_RESTRICT table, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) cells[i] = table[cells[i]];
  }
  HWY_INLINE F interpolated(std::size_t i) const {
    const Words dw;
    return interpolate(hn::Load(dw, cells + i), hn::Load(dw, x + i), hn::Load(dw, y + i));
  }
};

HWY_INLINE void place_texture(F tile, F u, F v, F footprint, std::size_t i, Lookups& texture) {
  const Floats d;
  const Words dw;
  const F side = level_side(footprint);
  const F first = hn::Sub(hn::Mul(hn::Add(tile, hn::Set(d, 3.0F * kTileSide)), hn::Set(d, 256.0F)),
                          hn::Mul(side, hn::Set(d, 3.0F)));
  const W x = rounded(hn::Mul(hn::Sub(u, hn::Floor(u)), side));
  const W y = rounded(hn::Add(first, hn::Mul(hn::Sub(v, hn::Floor(v)), side)));
  constexpr std::uint32_t kZero = (kRounderBits >> 8U) * (kTexelStride + 1U);
  const W row = hn::Mul(hn::ShiftRight<8>(y), hn::Set(dw, static_cast<std::uint32_t>(kTexelStride)));
  texture.set(i, hn::Sub(hn::Add(row, hn::ShiftRight<8>(x)), hn::Set(dw, kZero)), x, y);
}

HWY_INLINE void place_light(const Row& row, const FloorLight& light, std::size_t i, F depth, Lookups& lights) {
  const Floats d;
  const Words dw;
  const auto fixed = [&](F x, int count) HWY_ATTR {
    const F last = hn::Set(d, static_cast<float>(count - 1));
    return rounded(hn::Mul(hn::Min(hn::Max(x, hn::Zero(d)), last), hn::Set(d, 256.0F)));
  };
  const W x = fixed(hn::Add(hn::Set(d, row.eye_x), hn::Mul(depth, hn::Load(d, row.x_steps.data() + i))), light.width);
  const W y = fixed(hn::Add(hn::Set(d, row.eye_y), hn::Mul(depth, hn::Load(d, row.y_steps.data() + i))), light.height);
  const auto width = static_cast<std::uint32_t>(light.width);
  const W begin = hn::Mul(hn::ShiftRight<8>(y), hn::Set(dw, width));
  const W zero = hn::Set(dw, (kRounderBits >> 8U) * (width + 1U));
  lights.set(i, hn::Sub(hn::Add(begin, hn::ShiftRight<8>(x)), zero), x, y);
}

// From a to b.
HWY_INLINE F mixed(F a, F b, F share) { return hn::Add(a, hn::Mul(hn::Sub(b, a), share)); }

// Blue, green and red of a pixel in the low bytes of a word.
HWY_INLINE W pack(F blue, F green, F red) {
  const Floats d;
  const Words dw;
  const F most = hn::Set(d, 255.0F);
  const W byte = hn::Set(dw, 255U);
  const W b = hn::And(rounded(hn::Min(blue, most)), byte);
  const W g = hn::ShiftLeft<8>(hn::And(rounded(hn::Min(green, most)), byte));
  const W r = hn::ShiftLeft<16>(rounded(hn::Min(red, most)));
  return hn::Or(b, hn::Or(g, r));
}

// Three bytes of each word, one behind the other. `count` is a multiple of 16.
void store_colour(const std::uint32_t* words, std::size_t count, std::uint8_t* to) {
#if HWY_TARGET == HWY_SCALAR
  for (std::size_t i = 0; i < count; ++i) {
    for (unsigned k = 0; k < 3; ++k) to[3 * i + k] = static_cast<std::uint8_t>(words[i] >> (8U * k));
  }
#else
  // four pixels at a time; each store but the last writes four bytes too many, which the next puts right
  const hn::Full128<std::uint8_t> d;
  alignas(16) static constexpr std::uint8_t kOrder[16] = {0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, 3, 7, 11, 15};
  const auto order = hn::Load(d, kOrder);
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(words);
  std::size_t i = 0;
  for (; i + 4 < count; i += 4) hn::StoreU(hn::TableLookupBytes(hn::Load(d, bytes + 4 * i), order), d, to + 3 * i);
  HWY_ALIGN std::uint8_t last[16];
  hn::Store(hn::TableLookupBytes(hn::Load(d, bytes + 4 * i), order), d, last);
  std::copy_n(last, 12, to + 3 * i);
#endif
}

HWY_INLINE F field(const Row& row, Field which, std::size_t i) {
  return hn::Load(Floats(), row.fields[which].data() + i);
}

// A row of a strip in the making. It is drawn in three passes, each of which is short enough for a processor to work on
// many pixels at once: where everything is, what is found there, and how that looks.
struct Strip {
  Lookups texture;
  Lookups light;
  HWY_ALIGN float shades[kStripWidth];
  HWY_ALIGN std::uint32_t pixels[kStripWidth];
  std::array<std::size_t, kStripWidth> floors;  // where vectors begin in which the floor is seen
  std::size_t floor_count = 0;
};

HWY_INLINE void place(const Row& row, const FloorLight& light, const RowImages& images, std::size_t i, Strip& strip) {
  const Floats d;
  const F slope = hn::Set(d, row.slope);
  const F id = field(row, kId, i);
  const F inverse = hn::Add(field(row, kInverse, i), hn::Mul(field(row, kInverseRise, i), slope));
  const F depth = hn::IfThenElseZero(hn::Gt(inverse, hn::Zero(d)), hn::Div(hn::Set(d, 1.0F), inverse));
  if (images.depth) hn::StoreU(hn::IfThenElseZero(hn::Gt(id, hn::Zero(d)), depth), d, images.depth + i);
  if (images.ids) hn::StoreU(hn::DemoteTo(Shorts(), hn::ConvertTo(Ints(), id)), Shorts(), images.ids + i);
  if (!images.colour) return;

  const F u = hn::Add(field(row, kU, i), hn::Mul(depth, field(row, kUStep, i)));
  const F v_step = hn::Add(field(row, kVStep, i), hn::Mul(field(row, kVRise, i), slope));
  const F v = hn::Add(field(row, kV, i), hn::Mul(depth, v_step));
  const F footprint = hn::Add(field(row, kFootprint, i), hn::Mul(hn::Mul(depth, depth), field(row, kFootprintRise, i)));
  place_texture(field(row, kTile, i), u, v, footprint, i, strip.texture);
  const F shade = hn::Add(field(row, kShade, i), hn::Mul(field(row, kShadeRise, i), v));
  hn::Store(hn::Min(hn::Set(d, 1.0F), shade), d, strip.shades + i);

  if (hn::AllFalse(d, hn::Eq(id, hn::Set(d, static_cast<float>(kFloorId))))) return;
  place_light(row, light, i, depth, strip.light);
  strip.floors[strip.floor_count++] = i;
}

// Where there is nothing, the sky, which clouds and hills cover.
HWY_INLINE F before_sky(const Row& row, Field which, std::size_t i, F own, F cover, float sky, float sun) {
  const Floats d;
  const F lit = hn::Add(hn::Set(d, sky), hn::Mul(hn::Set(d, sun), field(row, kGlow, i)));
  return hn::IfThenElse(hn::Gt(field(row, kId, i), hn::Zero(d)), own, mixed(lit, field(row, which, i), cover));
}

HWY_INLINE void shade(const Row& row, std::size_t i, Strip& strip) {
  const Floats d;
  const F bright = hn::Mul(strip.texture.interpolated(i), hn::Set(d, 1.0F / 65536.0F));
  const F cover = hn::Add(field(row, kDark, i), hn::Mul(field(row, kContrast, i), bright));
  F light = hn::Load(d, strip.shades + i);
  const F id = field(row, kId, i);
  const auto is_floor = hn::Eq(id, hn::Set(d, static_cast<float>(kFloorId)));
  if (!hn::AllFalse(d, is_floor)) {
    constexpr auto kFull = static_cast<float>(FloorLight::kBrightest) / (255.0F * 65536.0F);
    light = hn::IfThenElse(is_floor, hn::Mul(strip.light.interpolated(i), hn::Set(d, kFull)), light);
  }
  light = hn::Mul(light, cover);
  F blue = hn::Mul(field(row, kBlue, i), light);
  F green = hn::Mul(field(row, kGreen, i), light);
  F red = hn::Mul(field(row, kRed, i), light);
  if (row.haze > 0.0F) {
    const F hidden = hn::IfThenElseZero(is_floor, hn::Set(d, row.haze));
    const Colour horizon = sky_colour(0.0F);
    blue = mixed(blue, hn::Set(d, horizon.b), hidden);
    green = mixed(green, hn::Set(d, horizon.g), hidden);
    red = mixed(red, hn::Set(d, horizon.r), hidden);
  }
  if (!hn::AllTrue(d, hn::Gt(id, hn::Zero(d)))) {
    const Colour sky = sky_colour(row.slope);
    const Colour sun = sun_glow(row.slope);
    blue = before_sky(row, kBlue, i, blue, cover, sky.b, sun.b);
    green = before_sky(row, kGreen, i, green, cover, sky.g, sun.g);
    red = before_sky(row, kRed, i, red, cover, sky.r, sun.r);
  }
  hn::Store(pack(blue, green, red), Words(), strip.pixels + i);
}

void draw(const Row& row, const FloorLight& light, const std::uint32_t* texels, const RowImages& images) {
  const auto count = static_cast<std::size_t>(row.lanes);
  const std::size_t lanes = hn::Lanes(Floats());
  Strip strip;
  for (std::size_t i = 0; i < count; i += lanes) place(row, light, images, i, strip);
  if (!images.colour) return;
  strip.texture.find(texels, 0, count);
  for (std::size_t k = 0; k < strip.floor_count; ++k) {
    strip.light.find(light.cells.data(), strip.floors[k], strip.floors[k] + lanes);
  }
  for (std::size_t i = 0; i < count; i += lanes) shade(row, i, strip);
  if (count > 0) store_colour(strip.pixels, count, images.colour);
}

}  // namespace threewe::sim::view::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace threewe::sim::view {

HWY_EXPORT(draw);

void draw_row(const Row& row, const FloorLight& light, const RowImages& images) {
  HWY_DYNAMIC_DISPATCH(draw)(row, light, tiles().data(), images);
}

}  // namespace threewe::sim::view
#endif
