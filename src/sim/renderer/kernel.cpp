// How columns of pixels get their depth, ids and colour. All products are unfused and all quotients exact, so that the
// bits are the same for every target.
#include "sim/renderer/kernel.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "sim/renderer/looks.hpp"
#include "sim/renderer/textures.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sim/renderer/kernel.cpp"
#include "threewe/core/highway-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace threewe::sim::view::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, kMostLanes>;
using Ints = hn::RebindToSigned<Floats>;
using Words = hn::RebindToUnsigned<Floats>;
using F = hn::Vec<Floats>;
using W = hn::Vec<Words>;

HWY_INLINE F set(float x) { return hn::Set(Floats(), x); }
HWY_INLINE W set(std::uint32_t x) { return hn::Set(Words(), x); }

// Adding this to a number in [0, 2^22) leaves the nearest whole number in the low bits: one operation, where converting
// takes several that guard against overflow.
constexpr float kRounder = 8388608.0F;
constexpr std::uint32_t kRounderBits = 0x4B000000U;

HWY_INLINE W rounded(F x) { return hn::BitCast(Words(), hn::Add(x, set(kRounder))); }

// Interpolates between the four bytes of a cell by the low 8 bits of x and y, in 1/65536. Two bytes at a time share a
// word.
HWY_INLINE F interpolate(W cell, W x, W y) {
  const W two_bytes = set(0x00FF00FFU);
  const W one = set(256U);
  const W weight_x = hn::And(x, set(255U));
  const W weight_y = hn::And(y, set(255U));
  const W left = hn::And(cell, two_bytes);
  const W right = hn::And(hn::ShiftRight<8>(cell), two_bytes);
  const W both = hn::Add(hn::Mul(left, hn::Sub(one, weight_x)), hn::Mul(right, weight_x));
  const W low = hn::And(both, set(0xFFFFU));
  const W high = hn::ShiftRight<16>(both);
  const W sum = hn::Add(hn::Mul(low, hn::Sub(one, weight_y)), hn::Mul(high, weight_y));
  return hn::ConvertTo(Floats(), hn::BitCast(Ints(), sum));
}

// 256 times the number of texels across the level that suits a footprint [texels of level 0]: a power of two, made
// from the exponent.
HWY_INLINE F level_side(F footprint) {
  constexpr std::uint32_t kOne = 127U << 23U;
  constexpr std::uint32_t kCoarsest = (127U + kTileLevels - 1U) << 23U;
  constexpr std::uint32_t kProduct = (127U + 127U + 15U) << 23U;  // 2^e times 2^(15 - e)
  const W power = hn::And(hn::BitCast(Words(), footprint), set(0x7F800000U));
  const W within = hn::Min(hn::Max(power, set(kOne)), set(kCoarsest));
  return hn::BitCast(Floats(), hn::Sub(set(kProduct), within));
}

// The first line of a level of a material's tile, in 1/256.
HWY_INLINE F first_line(Material material, F side) {
  const auto tile = static_cast<float>((static_cast<int>(material) * kTileLines + 3 * kTileSide) * 256);
  return hn::Sub(set(tile), hn::Mul(side, set(3.0F)));
}

// A place in a level that repeats, in 1/256 texel.
HWY_INLINE F within_level(F tiles, F side) { return hn::Mul(hn::Sub(tiles, hn::Floor(tiles)), side); }

// The cell at a rounded place; `width` is from one line of cells to the next.
HWY_INLINE W cell_at(W line, W place, std::uint32_t width) {
  const W zero = set((kRounderBits >> 8U) * (width + 1U));
  return hn::Add(hn::Sub(hn::Mul(hn::ShiftRight<8>(line), set(width)), zero), hn::ShiftRight<8>(place));
}

// From a to b.
HWY_INLINE F mixed(F a, F b, F share) { return hn::Add(a, hn::Mul(hn::Sub(b, a), share)); }

struct Pixel {
  F blue;
  F green;
  F red;
};

// Blue, green and red of a pixel in the low bytes of a word; whatever in the last.
HWY_INLINE W pack(const Pixel& pixel) {
  const F most = set(255.0F);
  const W b = rounded(hn::Min(pixel.blue, most));
  const W g = rounded(hn::Min(pixel.green, most));
  const W r = rounded(hn::Min(pixel.red, most));
  return hn::Or(b, hn::Or(hn::ShiftLeft<8>(g), hn::ShiftLeft<16>(r)));
}

// How the texture of a level surface is looked up.
class Texturing {
 public:
  HWY_INLINE Texturing(const Span& span, Lookups& to)
      : u_(set(span.u)),
        u_step_(set(span.u_step)),
        v_(set(span.v)),
        v_step_(set(span.v_step)),
        cells_(to.cells.data()),
        x_(to.x.data()),
        y_(to.y.data()) {}

  HWY_INLINE void place(std::size_t i, F depth, F side, F first) const {
    const Words d;
    const F u = hn::Add(u_, hn::Mul(depth, u_step_));
    const F v = hn::Add(v_, hn::Mul(depth, v_step_));
    const W x = rounded(hn::Add(first, within_level(u, side)));
    const W y = rounded(within_level(v, side));
    hn::StoreU(cell_at(x, y, kTexelStride), d, cells_ + i);
    hn::StoreU(x, d, x_ + i);
    hn::StoreU(y, d, y_ + i);
  }

 private:
  F u_;
  F u_step_;
  F v_;
  F v_step_;
  std::uint32_t* HWY_RESTRICT cells_;
  std::uint32_t* HWY_RESTRICT x_;
  std::uint32_t* HWY_RESTRICT y_;
};

// Draws the columns of a strip. Each is drawn in three passes, which are short enough for a processor to work on many
// pixels at once: where everything is, what is found there, and how that looks.
class Drawer {
 public:
  Drawer(const Rows& rows, const FloorLight& light, Strip& strip, const Target& target)
      : rows_(rows), light_(light), strip_(strip), target_(target) {}

  void draw_column(std::span<const Span> spans) {
    if (target_.ids) {
      for (const Span& span : spans)
        std::fill_n(column_of(strip_.ids, span) + span.begin, span.end - span.begin, span.id);
    }
    if (!target_.colour && !target_.depth) return;
    for (const Span& span : spans) {
      switch (span.way) {
        case Way::upright: place_upright(span); break;
        case Way::floor: place_floor(span); break;
        case Way::level:
        case Way::sky: place_level(span); break;
      }
    }
    if (!target_.colour) return;
    find(tiles().data(), strip_.texture, 0, rows_.count);
    for (const Span& span : spans) {
      if (span.way == Way::floor) find(light_.cells.data(), strip_.light, span.begin, span.end);
    }
    for (const Span& span : spans) {
      switch (span.way) {
        case Way::upright: shade<Way::upright>(span); break;
        case Way::level: shade<Way::level>(span); break;
        case Way::floor: shade<Way::floor>(span); break;
        case Way::sky: shade<Way::sky>(span); break;
      }
    }
  }

 private:
  template <class T>
  T* column_of(std::vector<T>& buffer, const Span& span) const {
    return buffer.data() + static_cast<std::size_t>(span.column) * strip_.pitch;
  }

  static HWY_INLINE F depth_at(F inverse) {
    return hn::IfThenElseZero(hn::Gt(inverse, set(0.0F)), hn::Div(set(1.0F), inverse));
  }

  // Rows of spans are drawn by whole vectors: what is too much is drawn anew by the next span.
  template <class Draw>
  static HWY_INLINE void for_rows(const Span& span, Draw draw) {
    for (int i = span.begin; i < span.end; i += static_cast<int>(hn::Lanes(Floats())))
      draw(static_cast<std::size_t>(i));
  }

  HWY_INLINE void place_upright(const Span& span) {
    const Floats d;
    const Words dw;
    const F depth = depth_at(set(span.inverse));
    if (target_.depth) {
      float* depths = column_of(strip_.depth, span);
      for_rows(span, [&](std::size_t i) HWY_ATTR { hn::StoreU(depth, d, depths + i); });
    }
    if (!target_.colour) return;
    const float* HWY_RESTRICT slopes = rows_.slopes.data();
    std::uint32_t* HWY_RESTRICT cells = strip_.texture.cells.data();
    std::uint32_t* HWY_RESTRICT ys = strip_.texture.y.data();
    const F side = level_side(set(span.footprint));
    const W line = upright_line(span, side);
    const F v = set(span.v);
    const F v_rise = hn::Mul(depth, set(span.v_step));
    for_rows(span, [&](std::size_t i) HWY_ATTR {
      const W y = rounded(within_level(hn::Add(v, hn::Mul(v_rise, hn::LoadU(d, slopes + i))), side));
      hn::StoreU(cell_at(line, y, kTexelStride), dw, cells + i);
      hn::StoreU(y, dw, ys + i);
    });
  }

  static HWY_INLINE W upright_line(const Span& span, F side) {
    return rounded(hn::Add(first_line(span.material, side), within_level(set(span.u), side)));
  }

  HWY_INLINE void place_level(const Span& span) {
    const Floats d;
    const F inverse = set(span.inverse);
    const F rise = set(span.inverse_rise);
    const F footprint = set(span.footprint);
    const Texturing texturing(span, strip_.texture);
    const float* HWY_RESTRICT slopes = rows_.slopes.data();
    float* depths = target_.depth ? column_of(strip_.depth, span) : nullptr;
    for_rows(span, [&](std::size_t i) HWY_ATTR {
      const F depth = depth_at(hn::Add(inverse, hn::Mul(rise, hn::LoadU(d, slopes + i))));
      if (depths) hn::StoreU(span.way == Way::sky ? hn::Zero(d) : depth, d, depths + i);
      const F side = level_side(hn::Mul(hn::Mul(depth, depth), footprint));
      texturing.place(i, depth, side, first_line(span.material, side));
    });
  }

  HWY_INLINE void place_floor(const Span& span) {
    const Floats d;
    const float* HWY_RESTRICT distances = rows_.floor.data();
    if (target_.depth) {
      float* depths = column_of(strip_.depth, span);
      for_rows(span, [&](std::size_t i) HWY_ATTR { hn::StoreU(hn::LoadU(d, distances + i), d, depths + i); });
    }
    if (!target_.colour) return;
    const FloorRows& known = floor_rows(span);
    const float* HWY_RESTRICT sides = known.side.data();
    const float* HWY_RESTRICT firsts = known.first.data();
    const Texturing texturing(span, strip_.texture);
    for_rows(span, [&](std::size_t i) HWY_ATTR {
      texturing.place(i, hn::LoadU(d, distances + i), hn::LoadU(d, sides + i), hn::LoadU(d, firsts + i));
    });
    place_light(span);
  }

  HWY_INLINE void place_light(const Span& span) {
    const Floats d;
    const Words dw;
    const float* HWY_RESTRICT distances = rows_.floor.data();
    std::uint32_t* HWY_RESTRICT cells = strip_.light.cells.data();
    std::uint32_t* HWY_RESTRICT xs = strip_.light.x.data();
    std::uint32_t* HWY_RESTRICT ys = strip_.light.y.data();
    const auto width = static_cast<std::uint32_t>(light_.width);
    const F last_x = set(256.0F * static_cast<float>(light_.width - 1));
    const F last_y = set(256.0F * static_cast<float>(light_.height - 1));
    const F x_step = set(span.light_x_step);
    const F y_step = set(span.light_y_step);
    const F eye_x = set(span.light_x);
    const F eye_y = set(span.light_y);
    for_rows(span, [&](std::size_t i) HWY_ATTR {
      const F depth = hn::LoadU(d, distances + i);
      const F x = hn::Add(eye_x, hn::Mul(depth, x_step));
      const F y = hn::Add(eye_y, hn::Mul(depth, y_step));
      const W at_x = rounded(hn::Min(hn::Max(x, hn::Zero(d)), last_x));
      const W at_y = rounded(hn::Min(hn::Max(y, hn::Zero(d)), last_y));
      hn::StoreU(cell_at(at_y, at_x, width), dw, cells + i);
      hn::StoreU(at_x, dw, xs + i);
      hn::StoreU(at_y, dw, ys + i);
    });
  }

  // Found when a material is first seen.
  const FloorRows& floor_rows(const Span& span) {
    const Floats d;
    FloorRows& rows = strip_.floors[static_cast<std::size_t>(span.material)];
    if (rows.is_known) return rows;
    rows.is_known = true;
    rows.side.resize(strip_.pitch);
    rows.first.resize(strip_.pitch);
    Span all;
    all.end = rows_.count;
    for_rows(all, [&](std::size_t i) HWY_ATTR {
      const F depth = hn::LoadU(d, rows_.floor.data() + i);
      const F side = level_side(hn::Mul(hn::Mul(depth, depth), set(span.footprint)));
      hn::StoreU(side, d, rows.side.data() + i);
      hn::StoreU(first_line(span.material, side), d, rows.first.data() + i);
    });
    return rows;
  }

  // One by one: the gather of AVX2 is slower on the machines that it was measured on.
  static HWY_INLINE void find(const std::uint32_t* HWY_RESTRICT table, Lookups& lookups, int begin, int end) {
    std::uint32_t* HWY_RESTRICT cells = lookups.cells.data();
    for (int i = begin; i < end; ++i) cells[i] = table[cells[i]];
  }

  template <Way way>
  HWY_INLINE void shade(const Span& span) {
    const Floats d;
    const Words dw;
    const float* HWY_RESTRICT slopes = rows_.slopes.data();
    const std::uint32_t* HWY_RESTRICT texels = strip_.texture.cells.data();
    const std::uint32_t* HWY_RESTRICT texel_x = strip_.texture.x.data();
    const std::uint32_t* HWY_RESTRICT texel_y = strip_.texture.y.data();
    const std::uint32_t* HWY_RESTRICT lights = strip_.light.cells.data();
    const std::uint32_t* HWY_RESTRICT light_x = strip_.light.x.data();
    const std::uint32_t* HWY_RESTRICT light_y = strip_.light.y.data();
    std::uint32_t* HWY_RESTRICT pixels = column_of(strip_.colour, span);
    constexpr auto kFull = static_cast<float>(FloorLight::kBrightest) / (255.0F * 65536.0F);
    const Span s = span;
    const F contrast = set(s.contrast * (1.0F / 65536.0F));
    const F foot = hn::Add(set(s.shade), hn::Mul(set(s.shade_rise), set(s.v)));
    const F rise = hn::Mul(set(s.shade_rise), hn::Mul(depth_at(set(s.inverse)), set(s.v_step)));
    const W x_at_one_depth = upright_line(s, level_side(set(s.footprint)));

    for (int row = s.begin; row < s.end; row += static_cast<int>(hn::Lanes(d))) {
      const auto i = static_cast<std::size_t>(row);
      const W x = way == Way::upright ? x_at_one_depth : hn::LoadU(dw, texel_x + i);
      const F bright = interpolate(hn::LoadU(dw, texels + i), x, hn::LoadU(dw, texel_y + i));
      const F cover = hn::Add(set(s.dark), hn::Mul(contrast, bright));
      F light = cover;
      if (way == Way::upright) {
        light = hn::Mul(cover, hn::Min(set(1.0F), hn::Add(foot, hn::Mul(rise, hn::LoadU(d, slopes + i)))));
      } else if (way == Way::floor) {
        const F found = interpolate(hn::LoadU(dw, lights + i), hn::LoadU(dw, light_x + i), hn::LoadU(dw, light_y + i));
        light = hn::Mul(cover, hn::Mul(found, set(kFull)));
      }
      Pixel pixel{hn::Mul(set(s.colour.b), light), hn::Mul(set(s.colour.g), light), hn::Mul(set(s.colour.r), light)};
      if (way == Way::floor && !rows_.haze.empty()) {
        const Colour horizon = sky_colour(0.0F);
        const F hidden = hn::LoadU(d, rows_.haze.data() + i);
        pixel = {mixed(pixel.blue, set(horizon.b), hidden), mixed(pixel.green, set(horizon.g), hidden),
                 mixed(pixel.red, set(horizon.r), hidden)};
      } else if (way == Way::sky) {
        const auto covered = [&](std::size_t channel, float own) HWY_ATTR {
          const F lit = hn::Add(hn::LoadU(d, rows_.sky[channel].data() + i),
                                hn::Mul(hn::LoadU(d, rows_.glow[channel].data() + i), set(s.glow)));
          return mixed(lit, set(own), cover);
        };
        pixel = {covered(0, s.colour.b), covered(1, s.colour.g), covered(2, s.colour.r)};
      }
      hn::StoreU(pack(pixel), dw, pixels + i);
    }
  }

  const Rows& rows_;
  const FloorLight& light_;
  Strip& strip_;
  const Target& target_;
};

// Columns become rows, four by four.
#if HWY_TARGET == HWY_SCALAR
void put_colour(const Strip& strip, std::size_t rows, const Target& target) {
  for (std::size_t r = 0; r < rows; ++r) {
    std::uint8_t* to = target.colour + 3 * target.width * r;
    for (std::size_t c = 0; c < target.columns; ++c) {
      for (unsigned k = 0; k < 3; ++k) *to++ = static_cast<std::uint8_t>(strip.colour[c * strip.pitch + r] >> (8U * k));
    }
  }
}
#else
using Four = hn::Full128<std::uint32_t>;
using Bytes = hn::Full128<std::uint8_t>;

// Three bytes of each of four words, and four bytes of whatever.
HWY_INLINE hn::Vec<Bytes> three_of_four(hn::Vec<Four> words) {
  const Bytes d;
  alignas(16) static constexpr std::uint8_t kOrder[16] = {0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, 3, 7, 11, 15};
  return hn::TableLookupBytes(hn::BitCast(d, words), hn::Load(d, kOrder));
}

// Four columns of four rows, as rows.
struct Block {
  hn::Vec<Bytes> row[4];

  HWY_INLINE Block(const std::uint32_t* HWY_RESTRICT from, std::size_t pitch) {
    const Four d;
    const hn::Repartition<std::uint64_t, Four> d2;
    const auto a = hn::LoadU(d, from);
    const auto b = hn::LoadU(d, from + pitch);
    const auto e = hn::LoadU(d, from + 2 * pitch);
    const auto f = hn::LoadU(d, from + 3 * pitch);
    const auto ab_low = hn::BitCast(d2, hn::InterleaveLower(d, a, b));
    const auto ab_high = hn::BitCast(d2, hn::InterleaveUpper(d, a, b));
    const auto ef_low = hn::BitCast(d2, hn::InterleaveLower(d, e, f));
    const auto ef_high = hn::BitCast(d2, hn::InterleaveUpper(d, e, f));
    row[0] = three_of_four(hn::BitCast(d, hn::InterleaveLower(d2, ab_low, ef_low)));
    row[1] = three_of_four(hn::BitCast(d, hn::InterleaveUpper(d2, ab_low, ef_low)));
    row[2] = three_of_four(hn::BitCast(d, hn::InterleaveLower(d2, ab_high, ef_high)));
    row[3] = three_of_four(hn::BitCast(d, hn::InterleaveUpper(d2, ab_high, ef_high)));
  }
};

void put_colour(const Strip& strip, std::size_t rows, const Target& target) {
  const Bytes d;
  const std::size_t pitch = strip.pitch;
  const std::size_t width = 3 * target.width;
  const std::size_t columns = target.columns;
  for (std::size_t r = 0; r < rows; r += 4) {
    const std::uint32_t* HWY_RESTRICT from = strip.colour.data() + r;
    std::uint8_t* HWY_RESTRICT to = target.colour + width * r;
    std::size_t c = 0;
    if (r + 4 <= rows) {  // whole blocks: what is written too much is written anew by the next
      for (; c + 6 <= columns; c += 4, from += 4 * pitch, to += 12) {
        const Block block(from, pitch);
        for (std::size_t k = 0; k < 4; ++k) hn::StoreU(block.row[k], d, to + k * width);
      }
    }
    for (; c < columns; c += 4, from += 4 * pitch, to += 12) {
      const Block block(from, pitch);
      const std::size_t bytes = 3 * std::min<std::size_t>(columns - c, 4);
      for (std::size_t k = 0; k < std::min<std::size_t>(rows - r, 4); ++k) {
        HWY_ALIGN std::uint8_t whole[16];
        hn::Store(block.row[k], d, whole);
        std::memcpy(to + k * width, whole, bytes);
      }
    }
  }
}
#endif

template <class T>
void put_plain(const std::vector<T>& from, std::size_t pitch, std::size_t rows, std::size_t width, std::size_t columns,
               T* to) {
  for (std::size_t r = 0; r < rows; ++r) {
    for (std::size_t c = 0; c < columns; ++c) to[r * width + c] = from[c * pitch + r];
  }
}

void draw(std::span<const Span> spans, const Rows& rows, const FloorLight& light, Strip& strip, const Target& target) {
  Drawer drawer(rows, light, strip, target);
  for (auto first = spans.begin(); first != spans.end();) {
    const auto last = std::find_if(first, spans.end(), [&](const Span& s) { return s.column != first->column; });
    drawer.draw_column({first, last});
    first = last;
  }
  const auto count = static_cast<std::size_t>(rows.count);
  if (target.colour) put_colour(strip, count, target);
  if (target.depth) put_plain(strip.depth, strip.pitch, count, target.width, target.columns, target.depth);
  if (target.ids) put_plain(strip.ids, strip.pitch, count, target.width, target.columns, target.ids);
}

}  // namespace threewe::sim::view::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace threewe::sim::view {

HWY_EXPORT(draw);

void begin_strips(int rows, Strip& strip) {
  constexpr std::size_t kLanes = kMostLanes;
  strip.pitch = (static_cast<std::size_t>(rows) + 2 * kLanes - 1) / kLanes * kLanes;
  strip.colour.resize(kStripWidth * strip.pitch);
  strip.depth.resize(kStripWidth * strip.pitch);
  strip.ids.resize(kStripWidth * strip.pitch);
  for (FloorRows& floor : strip.floors) floor.is_known = false;
  for (Lookups* lookups : {&strip.texture, &strip.light}) {
    lookups->cells.resize(strip.pitch);
    lookups->x.resize(strip.pitch);
    lookups->y.resize(strip.pitch);
  }
}

void draw_strip(std::span<const Span> spans, const Rows& rows, const FloorLight& light, Strip& strip,
                const Target& target) {
  HWY_DYNAMIC_DISPATCH(draw)(spans, rows, light, strip, target);
}

}  // namespace threewe::sim::view
#endif
