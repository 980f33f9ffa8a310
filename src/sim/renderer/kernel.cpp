// Pictures, block by block. All products are unfused and all quotients exact, so that the bits are the same for every
// target.
#include "sim/renderer/kernel.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sim/renderer/kernel.cpp"
#include "core/highway-inl.hpp"
//
#include "sim/renderer/shade-inl.hpp"
#include "sim/renderer/visible-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace threewe::sim::view::HWY_NAMESPACE {

// A colour is tint * texel * light * gain. Texel and light are in 1/170 each: their product takes 16 bits, and the
// upper 16 of its product with the tint are the colour in 1/112.9, which `scale` / 2^16 takes away.
struct Gain {
  alignas(16) std::array<std::uint16_t, 8> scale{};  // blue, green, red, nothing; for two pixels
  alignas(16) std::array<std::uint16_t, 8> half{};   // that is rounded up

  explicit Gain(const Colour& gain) {
    constexpr float kScale = 581.0F;
    const std::array channels = {gain.b, gain.g, gain.r, 0.0F};
    for (std::size_t i = 0; i < scale.size(); ++i) {
      scale[i] = static_cast<std::uint16_t>(std::lround(kScale * channels[i % 4]));
      half[i] = static_cast<std::uint16_t>(scale[i] == 0 ? 0 : 32768 / scale[i]);
    }
  }
};

// What colours are made of, from the first pixel of a band. Pointers of their own: the compiler believes that pixels
// may be written over those of vectors.
struct Parts {
  const std::uint32_t* HWY_RESTRICT texel;
  const std::uint32_t* HWY_RESTRICT light;
  const std::uint32_t* HWY_RESTRICT tint;
  const std::uint32_t* HWY_RESTRICT veil;  // null where there is none
};

// Three bytes a pixel.
#if HWY_TARGET == HWY_SCALAR
void make_colours(const Parts& parts, std::size_t first, const Gain& gain, std::uint8_t* to) {
  for (std::size_t i = first; i < first + kBlock; ++i) {
    const std::uint32_t factor = parts.texel[i] * parts.light[i];
    for (unsigned k = 0; k < 3; ++k) {
      const std::uint32_t tint = parts.tint[i] >> (8U * k) & 255U;
      const std::uint32_t fine = std::min(((tint << 8U) * factor >> 16U) + gain.half[k], 65535U);
      const std::uint32_t colour = std::min(fine * gain.scale[k] >> 16U, 255U);
      const std::uint32_t veil = parts.veil ? parts.veil[i] >> (8U * k) & 255U : 0U;
      *to++ = static_cast<std::uint8_t>(std::min(colour + veil, 255U));
    }
  }
}
#else
using Pixels = hn::CappedTag<std::uint32_t, kWidestBlock>;
using Channels = hn::Repartition<std::uint16_t, Pixels>;
using Bytes = hn::Repartition<std::uint8_t, Pixels>;

// Twelve bytes and four zeros for every four pixels.
HWY_INLINE hn::Vec<Bytes> colours_of(const Parts& parts, std::size_t i, const Gain& gain) {
  const Bytes d8;
  const Channels d16;
  const Pixels d32;
  constexpr std::uint8_t k0 = 0x80;  // nothing
  alignas(16) static constexpr std::uint8_t kFirst[16] = {0, 1, 0, 1, 0, 1, 0, 1, 4, 5, 4, 5, 4, 5, 4, 5};
  alignas(16) static constexpr std::uint8_t kSecond[16] = {8, 9, 8, 9, 8, 9, 8, 9, 12, 13, 12, 13, 12, 13, 12, 13};
  alignas(16) static constexpr std::uint8_t kLower[16] = {0, 2, 4, 8, 10, 12, k0, k0, k0, k0, k0, k0, k0, k0, k0, k0};
  alignas(16) static constexpr std::uint8_t kUpper[16] = {k0, k0, k0, k0, k0, k0, 0, 2, 4, 8, 10, 12, k0, k0, k0, k0};
  const auto scale = hn::LoadDup128(d16, gain.scale.data());
  const auto half = hn::LoadDup128(d16, gain.half.data());
  const auto texel = hn::BitCast(d16, hn::LoadU(d32, parts.texel + i));
  const auto light = hn::BitCast(d16, hn::LoadU(d32, parts.light + i));
  const auto tint = hn::BitCast(d8, hn::LoadU(d32, parts.tint + i));
  const auto factor = hn::BitCast(d8, hn::Mul(texel, light));
  const auto colours = [&](auto tints, const std::uint8_t* order) HWY_ATTR {
    const auto factors = hn::BitCast(d16, hn::TableLookupBytes(factor, hn::LoadDup128(d8, order)));
    const auto fine = hn::SaturatedAdd(hn::MulHigh(hn::BitCast(d16, tints), factors), half);
    return hn::BitCast(d8, hn::Min(hn::MulHigh(fine, scale), hn::Set(d16, std::uint16_t{255})));
  };
  const auto zero = hn::Zero(d8);
  const auto lower = colours(hn::InterleaveLower(d8, zero, tint), kFirst);
  const auto upper = colours(hn::InterleaveUpper(d8, zero, tint), kSecond);
  auto all = hn::Or(hn::TableLookupBytesOr0(lower, hn::LoadDup128(d8, kLower)),
                    hn::TableLookupBytesOr0(upper, hn::LoadDup128(d8, kUpper)));
  if (parts.veil) {
    alignas(16) static constexpr std::uint8_t kThree[16] = {0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, k0, k0, k0, k0};
    const auto veil = hn::BitCast(d8, hn::LoadU(d32, parts.veil + i));
    all = hn::SaturatedAdd(all, hn::TableLookupBytesOr0(veil, hn::LoadDup128(d8, kThree)));
  }
  return all;
}

HWY_INLINE void make_colours(const Parts& parts, std::size_t first, const Gain& gain, std::uint8_t* to) {
  const Pixels d32;
  const hn::Half<Pixels> half;
  const hn::Half<hn::Half<Pixels> > quarter;
  for (std::size_t i = first; i < first + kBlock; i += hn::Lanes(d32), to += 3 * hn::Lanes(d32)) {
    const auto all = hn::BitCast(d32, colours_of(parts, i, gain));
#if HWY_MAX_BYTES >= 32
    alignas(64) static constexpr std::uint32_t kPlace[16] = {0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, 0, 0, 0, 0};
    alignas(32) static constexpr std::uint32_t kPlace8[8] = {0, 1, 2, 4, 5, 6, 0, 0};
    const auto together = hn::TableLookupLanes(all, hn::SetTableIndices(d32, hn::Lanes(d32) == 16 ? kPlace : kPlace8));
#else
    const auto together = all;
#endif
    auto* words = reinterpret_cast<std::uint32_t*>(to);
    hn::StoreU(hn::LowerHalf(half, together), half, words);
    hn::StoreU(hn::LowerHalf(quarter, hn::UpperHalf(half, together)), quarter, words + hn::Lanes(half));
  }
}
#endif

// Draws the blocks of a picture.
class Drawer {
 public:
  Drawer(const Drawing& drawing, BlockWork& work) : drawing_(drawing), gain_(drawing.shading.gain), work_(work) {}

  void draw(std::size_t first) {
    const Columns columns = columns_of(drawing_.view, drawing_.candidates, first);
    Finder(drawing_, columns, work_).run();
    const auto width = static_cast<std::size_t>(drawing_.view.camera.width);
    const std::size_t count = std::min<std::size_t>(kBlock, width - first);
    const Images& images = drawing_.images;
    if (!images.ids.empty()) put_ids(images.ids.data() + first, width, count);
    if (!images.depth.empty()) put_depth(images.depth.data() + first, width, count);
    if (images.colour.empty()) return;
    Shader shader(drawing_, columns, work_);
    for (std::size_t begin = 0; begin < rows(); begin += kBand) {
      const Stretch band{begin, std::min(begin + kBand, rows())};
      shader.run(band);
      find_texels(band.end - band.begin);
      put_colours(band, images.colour.data() + 3 * first, 3 * width, 3 * count);
    }
  }

 private:
  std::size_t rows() const { return static_cast<std::size_t>(drawing_.rows.count); }

  void put_depth(float* HWY_RESTRICT to, std::size_t width, std::size_t count) const {
    const Floats d;
    const float* HWY_RESTRICT from = work_.depth.data();
    const auto seen = [&](std::size_t i) HWY_ATTR {
      const F depth = load(from + i);
      return hn::IfThenElseZero(hn::Lt(depth, set(std::numeric_limits<float>::infinity())), depth);
    };
    for (std::size_t r = 0; r < rows(); ++r, from += kBlock, to += width) {
      if (count == kBlock) {
        for_lanes([&](std::size_t i) HWY_ATTR { hn::StoreU(seen(i), d, to + i); });
      } else {
        for (std::size_t i = 0; i < count; ++i) to[i] = std::isinf(from[i]) ? 0.0F : from[i];
      }
    }
  }

  void put_ids(std::int16_t* HWY_RESTRICT to, std::size_t width, std::size_t count) {
    find_ids();
    const std::int16_t* HWY_RESTRICT ids = work_.ids.data() + drawing_.place.floors.size() + 1;  // floors are negative
    const std::int32_t* HWY_RESTRICT owners = work_.owner.data();
    for (std::size_t r = 0; r < rows(); ++r, owners += kBlock, to += width) {
      for (std::size_t i = 0; i < count; ++i) to[i] = ids[owners[i]];
    }
  }

  // The id of every owner, from the last floor on.
  void find_ids() {
    work_.ids.assign(drawing_.place.floors.size() + 1, kFloorId);
    work_.ids.resize(work_.ids.size() + kFirstSurface, kNothingId);
    work_.ids[work_.ids.size() - kFirstSurface + kCeiling] = kCeilingId;
    for (std::size_t k = 0; k < work_.surface_count; ++k) {
      work_.ids.push_back(work_.surfaces[k].candidate->visible->id);
    }
  }

  void find_texels(std::size_t rows) {
    const std::uint8_t* HWY_RESTRICT table = tiles().data();
    std::uint32_t* HWY_RESTRICT texels = work_.texel.data();
    look_up(table, texels, rows * kBlock);
    const std::uint32_t detail = detail_of(drawing_.shading);
    if (detail == kWhole) return;
    for (std::size_t i = 0; i < rows * kBlock; ++i) texels[i] = (texels[i] * detail + plain_of(detail)) >> 8U;
  }

  void put_colours(const Stretch& band, std::uint8_t* to, std::size_t width, std::size_t count) const {
    const Gain gain = gain_;
    const Parts parts{work_.texel.data(), work_.light.data(), work_.tint.data(),
                      work_.veil.empty() ? nullptr : work_.veil.data()};
    constexpr std::size_t kBytes = std::size_t{3} * kBlock;
    to += width * band.begin;
    for (std::size_t r = 0; r < band.end - band.begin; ++r, to += width) {
      if (count == kBytes) {
        make_colours(parts, r * kBlock, gain, to);
      } else {
        std::array<std::uint8_t, kBytes> all;
        make_colours(parts, r * kBlock, gain, all.data());
        std::memcpy(to, all.data(), count);
      }
    }
  }

  const Drawing& drawing_;
  Gain gain_;
  BlockWork& work_;
};

void draw_blocks(const Drawing& drawing, BlockWork& work) {
  Drawer drawer(drawing, work);
  const auto width = static_cast<std::size_t>(drawing.view.camera.width);
  for (std::size_t first = 0; first < width; first += kBlock) drawer.draw(first);
}

}  // namespace threewe::sim::view::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace threewe::sim::view {
namespace {

void begin(LevelRows& level, std::size_t rows) {
  level.is_known = false;
  level.scale.resize(rows);
  level.u.resize(rows);
  level.v.resize(rows);
  level.mask.resize(rows);
  level.stride.resize(rows);
  level.first.resize(rows);
}

}  // namespace

HWY_EXPORT(draw_blocks);

void draw(const Drawing& drawing, BlockWork& work) {
  const auto rows = static_cast<std::size_t>(drawing.rows.count);
  const std::size_t pixels = rows * kWidestBlock;
  work.depth.resize(pixels);
  work.owner.resize(pixels);
  for (auto* band : {&work.texel, &work.light, &work.tint, &work.cell, &work.within})
    band->resize(kBand * kWidestBlock);
  work.veil.resize(drawing.place.is_open ? kBand * kWidestBlock : 0);
  for (LevelRows& floor : work.floors) begin(floor, rows + kWidestBlock);
  begin(work.others, rows + kWidestBlock);
  work.patterns.fill({});
  work.colours.assign(drawing.candidates.walls.size() + drawing.candidates.others.size(), {});
  HWY_DYNAMIC_DISPATCH(draw_blocks)(drawing, work);
}

}  // namespace threewe::sim::view
#endif
