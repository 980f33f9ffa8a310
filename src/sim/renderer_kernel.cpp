// How a row of pixels gets its depth, ids and colour. All products are unfused and all quotients exact, so that the
// bits are the same for every target.
#include "sim/renderer_kernel.hpp"

#include <cstddef>

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
using Bytes = hn::Rebind<std::uint8_t, Floats>;
using F = hn::Vec<Floats>;
using I = hn::Vec<Ints>;

// Interpolates between the four bytes of a cell, 0 to 255.
HWY_INLINE F interpolate(I cell, F x, F y) {
  const Floats d;
  const Ints di;
  const I byte = hn::Set(di, 255);
  const F a = hn::ConvertTo(d, hn::And(cell, byte));
  const F b = hn::ConvertTo(d, hn::And(hn::ShiftRight<8>(cell), byte));
  const F c = hn::ConvertTo(d, hn::And(hn::ShiftRight<16>(cell), byte));
  const F e = hn::ConvertTo(d, hn::And(hn::ShiftRight<24>(cell), byte));
  const F low = hn::Add(a, hn::Mul(x, hn::Sub(b, a)));
  const F high = hn::Add(c, hn::Mul(x, hn::Sub(e, c)));
  return hn::Add(low, hn::Mul(y, hn::Sub(high, low)));
}

// The number of texels across the level that suits a footprint [texels of level 0]: a power of two.
HWY_INLINE F level_side(F footprint) {
  const Floats d;
  const Ints di;
  const I exponent = hn::Sub(hn::ShiftRight<23>(hn::BitCast(di, footprint)), hn::Set(di, 127));
  const I level = hn::Min(hn::Max(exponent, hn::Zero(di)), hn::Set(di, kTileLevels - 1));
  return hn::BitCast(d, hn::ShiftLeft<23>(hn::Sub(hn::Set(di, 134), level)));
}

// Where a texture is looked up: all of these are whole numbers below 2^24.
HWY_INLINE F brightness(const std::int32_t* HWY_RESTRICT texels, F tile, F u, F v, F side) {
  const Floats d;
  const Ints di;
  const F last = hn::Sub(side, hn::Set(d, 1.0F));
  const F x = hn::Mul(hn::Sub(u, hn::Floor(u)), side);
  const F y = hn::Mul(hn::Sub(v, hn::Floor(v)), side);
  const F x0 = hn::Min(hn::Floor(x), last);
  const F y0 = hn::Min(hn::Floor(y), last);
  const F begin = hn::Sub(hn::Set(d, static_cast<float>(kTileStride)), hn::Mul(hn::Add(side, side), side));
  const F at = hn::Add(hn::Add(tile, begin), hn::Add(hn::Mul(y0, side), x0));
  const I texel = hn::GatherIndex(di, texels, hn::ConvertTo(di, at));
  return interpolate(texel, hn::Sub(x, x0), hn::Sub(y, y0));
}

HWY_INLINE F floor_light(const Row& row, const FloorLight& light, std::size_t i, F depth) {
  const Floats d;
  const Ints di;
  const auto clamp = [&](F x, int count) HWY_ATTR {
    return hn::Min(hn::Max(x, hn::Zero(d)), hn::Set(d, static_cast<float>(count - 1)));
  };
  const F x = clamp(hn::Add(hn::Set(d, row.eye_x), hn::Mul(depth, hn::Load(d, row.x_steps.data() + i))), light.width);
  const F y = clamp(hn::Add(hn::Set(d, row.eye_y), hn::Mul(depth, hn::Load(d, row.y_steps.data() + i))), light.height);
  const F x0 = hn::Floor(x);
  const F y0 = hn::Floor(y);
  const F at = hn::Add(hn::Mul(y0, hn::Set(d, static_cast<float>(light.width))), x0);
  const auto* cells = reinterpret_cast<const std::int32_t*>(light.cells.data());
  const I cell = hn::GatherIndex(di, cells, hn::ConvertTo(di, at));
  return hn::Mul(interpolate(cell, hn::Sub(x, x0), hn::Sub(y, y0)), hn::Set(d, 1.0F / 255.0F));
}

HWY_INLINE auto to_byte(F value) {
  const Floats d;
  const Ints di;
  return hn::DemoteTo(Bytes(), hn::ConvertTo(di, hn::Add(value, hn::Set(d, 0.5F))));
}

void draw(const Row& row, const FloorLight& light, const std::uint32_t* texels, const RowImages& images) {
  const Floats d;
  const Ints di;
  const auto field = [&](Field which, std::size_t i) HWY_ATTR { return hn::Load(d, row.fields[which].data() + i); };
  const F slope = hn::Set(d, row.slope);
  const Colour sky = sky_colour(row.slope);
  for (std::size_t i = 0; i < static_cast<std::size_t>(row.lanes); i += hn::Lanes(d)) {
    // how far it is
    const F id = field(kId, i);
    const F inverse = hn::Add(field(kInverse, i), hn::Mul(field(kInverseRise, i), slope));
    const auto something = hn::Gt(id, hn::Zero(d));
    const F depth = hn::IfThenElseZero(something, hn::Div(hn::Set(d, 1.0F), inverse));
    if (images.depth) hn::StoreU(depth, d, images.depth + i);
    if (images.ids) hn::StoreU(hn::DemoteTo(Shorts(), hn::ConvertTo(di, id)), Shorts(), images.ids + i);
    if (!images.colour) continue;

    // its texture
    const F u = hn::Add(field(kU, i), hn::Mul(depth, field(kUStep, i)));
    const F v_step = hn::Add(field(kVStep, i), hn::Mul(field(kVRise, i), slope));
    const F v = hn::Add(field(kV, i), hn::Mul(depth, v_step));
    const F footprint = hn::Add(field(kFootprint, i), hn::Mul(hn::Mul(depth, depth), field(kFootprintRise, i)));
    const F bright =
        brightness(reinterpret_cast<const std::int32_t*>(texels), field(kTile, i), u, v, level_side(footprint));

    // its shade
    F shade = hn::Min(hn::Set(d, 1.0F), hn::Add(field(kShade, i), hn::Mul(field(kShadeRise, i), v)));
    const auto is_floor = hn::Eq(id, hn::Set(d, static_cast<float>(kFloorId)));
    if (!hn::AllFalse(d, is_floor)) {
      shade = hn::IfThenElse(is_floor, floor_light(row, light, i, depth), shade);
    }
    shade = hn::Mul(shade, hn::Add(field(kDark, i), hn::Mul(field(kContrast, i), bright)));

    F blue = hn::Mul(field(kBlue, i), shade);
    F green = hn::Mul(field(kGreen, i), shade);
    F red = hn::Mul(field(kRed, i), shade);
    if (!hn::AllTrue(d, something)) {
      blue = hn::IfThenElse(something, blue, hn::Set(d, sky.b));
      green = hn::IfThenElse(something, green, hn::Set(d, sky.g));
      red = hn::IfThenElse(something, red, hn::Set(d, sky.r));
    }
    hn::StoreInterleaved3(to_byte(blue), to_byte(green), to_byte(red), Bytes(), images.colour + 3 * i);
  }
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
