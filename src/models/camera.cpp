// Noise for a million values an image. Each draws from a hash of its own place, whose parts are added up to something
// bell-shaped. Whole numbers throughout for colours, so that the bits are the same for every target.
#include "models/camera.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "models/camera.cpp"
#include "core/highway-inl.hpp"

#ifndef THREEWE_MODELS_CAMERA_ONCE
#define THREEWE_MODELS_CAMERA_ONCE
namespace threewe::models::camera {

// Values that are served at a time, more than any vector holds.
constexpr std::size_t kBlock = 64;
struct alignas(64) Words {
  std::array<std::uint32_t, kBlock> list;
};

// Four uniform whole numbers added up: for a colour of 4 bits each, weighted 4, 5, 4, 5 so that the sums are not
// coarser than a level; for a depth of 8 bits each.
constexpr int kColorMean = 135;
constexpr double kColorSpread = 41.743262929484;  // sqrt(2 (4^2 + 5^2) (16^2 - 1) / 12)
constexpr float kDepthMean = 510.0F;
constexpr double kDepthSpread = 147.79941361;  // sqrt(4 (256^2 - 1) / 12)

struct Seed {
  std::uint32_t before;
  std::uint32_t within;
};

}  // namespace threewe::models::camera
#endif

HWY_BEFORE_NAMESPACE();
namespace threewe::models::camera::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using U32 = hn::CappedTag<std::uint32_t, 16>;
using U16 = hn::CappedTag<std::uint16_t, 32>;
using I16 = hn::RebindToSigned<U16>;
using U8 = hn::Rebind<std::uint8_t, U16>;
using F32 = hn::RebindToFloat<U32>;

// Random words for the places from `first` on: two rounds of multiplying and shifting (Wellons, "lowbias32").
void hash(Seed seed, std::uint32_t first, Words& words) {
  const U32 d;
  const auto before = hn::Set(d, seed.before);
  const auto within = hn::Set(d, seed.within);
  auto place = hn::Iota(d, first);
  for (std::size_t i = 0; i < kBlock; i += hn::Lanes(d)) {
    auto x = hn::Add(place, before);
    x = hn::Xor(x, hn::ShiftRight<16>(x));
    x = hn::Mul(x, hn::Set(d, 0x7FEB352DU));
    x = hn::Xor(hn::Add(x, within), hn::ShiftRight<15>(x));
    x = hn::Mul(x, hn::Set(d, 0x846CA68BU));
    x = hn::Xor(x, hn::ShiftRight<16>(x));
    hn::Store(x, d, words.list.data() + i);
    place = hn::Add(place, hn::Set(d, static_cast<std::uint32_t>(hn::Lanes(d))));
  }
}

// Half a word of noise for each of 2 kBlock colours.
void add_to_colors(const Words& words, std::int16_t scale, std::uint8_t* HWY_RESTRICT color) {
  const U16 d;
  const I16 di;
  const auto* halves = reinterpret_cast<const std::uint16_t*>(words.list.data());
  const auto nibbles = hn::Set(d, std::uint16_t{0x0F0F});
  const auto byte = hn::Set(d, std::uint16_t{0x00FF});
  for (std::size_t i = 0; i < 2 * kBlock; i += hn::Lanes(d)) {
    const auto half = hn::LoadU(d, halves + i);
    const auto upper = hn::And(hn::ShiftRight<4>(half), nibbles);
    const auto pairs = hn::Add(hn::ShiftLeft<2>(hn::Add(hn::And(half, nibbles), upper)), upper);
    const auto sum = hn::BitCast(di, hn::Add(hn::And(pairs, byte), hn::ShiftRight<8>(pairs)));
    const auto centred = hn::ShiftLeft<3>(hn::Sub(sum, hn::Set(di, std::int16_t{kColorMean})));
    const auto noise = hn::MulFixedPoint15(centred, hn::Set(di, scale));
    const auto value = hn::PromoteTo(di, hn::LoadU(U8(), color + i));
    hn::StoreU(hn::DemoteTo(U8(), hn::Add(value, noise)), U8(), color + i);
  }
}

// A word of noise for each of kBlock depths.
void measure_depths(const Words& words, float sigma, float near, float far, float* HWY_RESTRICT depth) {
  const U32 d;
  const F32 df;
  const hn::RebindToSigned<F32> di;
  const auto bytes = hn::Set(d, 0x00FF00FFU);
  for (std::size_t i = 0; i < kBlock; i += hn::Lanes(d)) {
    const auto word = hn::Load(d, words.list.data() + i);
    const auto pairs = hn::Add(hn::And(word, bytes), hn::And(hn::ShiftRight<8>(word), bytes));
    const auto sum = hn::Add(hn::And(pairs, hn::Set(d, 0xFFFFU)), hn::ShiftRight<16>(pairs));
    const auto centred = hn::Sub(hn::ConvertTo(df, hn::BitCast(di, sum)), hn::Set(df, kDepthMean));
    const auto truth = hn::LoadU(df, depth + i);
    const auto spread = hn::Mul(hn::Mul(truth, truth), hn::Set(df, sigma));
    const auto measured = hn::Add(truth, hn::Mul(spread, centred));
    const auto valid = hn::And(hn::And(hn::Gt(truth, hn::Zero(df)), hn::Ge(measured, hn::Set(df, near))),
                               hn::Le(measured, hn::Set(df, far)));
    hn::StoreU(hn::IfThenElseZero(valid, measured), df, depth + i);
  }
}

// Serves values block by block, `serve(words, block)`; the last few by way of a whole block.
template <std::size_t kValues, class T, class Serve>
HWY_INLINE void serve_all(Seed seed, std::span<T> values, const Serve& serve) {
  Words words;
  std::uint32_t place = 0;
  for (; values.size() >= kValues; values = values.subspan(kValues), place += kBlock) {
    hash(seed, place, words);
    serve(words, values.data());
  }
  if (values.empty()) return;
  std::array<T, kValues> rest{};
  std::copy(values.begin(), values.end(), rest.begin());
  hash(seed, place, words);
  serve(words, rest.data());
  std::copy_n(rest.begin(), values.size(), values.begin());
}

void add_color_noise(Seed seed, std::int16_t scale, std::span<std::uint8_t> color) {
  serve_all<2 * kBlock>(seed, color,
                        [=](const Words& words, std::uint8_t* block) { add_to_colors(words, scale, block); });
}

void measure_depth(Seed seed, float sigma, float near, float far, std::span<float> depth) {
  serve_all<kBlock>(seed, depth,
                    [=](const Words& words, float* block) { measure_depths(words, sigma, near, far, block); });
}

}  // namespace threewe::models::camera::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace threewe::models {
namespace camera {

HWY_EXPORT(add_color_noise);
HWY_EXPORT(measure_depth);

}  // namespace camera

CameraSpec varied(const CameraSpec& spec, const Variation& variation) {
  CameraSpec camera = spec;
  const Pose2D& offset = variation.camera_offset;
  camera.base_from_camera = {spec.base_from_camera.x + offset.x, spec.base_from_camera.y + offset.y,
                             spec.base_from_camera.theta + offset.theta};
  camera.mount_height += variation.camera_height;
  camera.sigma *= variation.camera_noise;
  if (camera.depth) camera.depth->sigma *= variation.camera_noise;
  return camera;
}

std::array<double, 3> color_gains(const Variation& variation, const RngKey& key) {
  const double all = variation.light * variation.exposure;
  std::array<double, 3> gains{all, all, all};
  if (variation.color_jitter == 0.0) return gains;
  constexpr std::uint32_t kLane = 1;  // noise has the first
  for (std::size_t i = 0; i < gains.size(); ++i) {
    gains[i] *= std::max(0.0, 1.0 + variation.color_jitter * normal(key, i, kLane));
  }
  return gains;
}

void add_color_noise(const CameraSpec& spec, const RngKey& key, std::uint64_t image, std::span<std::uint8_t> color) {
  if (spec.sigma == 0.0) return;
  const auto bits = random_bits(key, image);
  // what the noise is multiplied by, in 1/4096 of its spread
  const auto scale = static_cast<std::int16_t>(std::lround(4096.0 * spec.sigma / camera::kColorSpread));
  HWY_DYNAMIC_DISPATCH(camera::add_color_noise)(camera::Seed{bits[0], bits[1]}, scale, color);
}

void measure_depth(const DepthSpec& spec, const RngKey& key, std::uint64_t image, std::span<float> depth) {
  const auto bits = random_bits(key, image);
  HWY_DYNAMIC_DISPATCH(camera::measure_depth)
  (camera::Seed{bits[2], bits[3]}, static_cast<float>(spec.sigma / camera::kDepthSpread),
   static_cast<float>(spec.range_min), static_cast<float>(spec.range_max), depth);
}

}  // namespace threewe::models
#endif
