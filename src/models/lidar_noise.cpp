// In passes: words, four counters of Philox at a time or more; normal numbers; ranges.
#include "models/lidar_noise.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <numbers>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "models/lidar_noise.cpp"
#include "core/highway-inl.hpp"
//

HWY_BEFORE_NAMESPACE();
namespace threewe::models::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Words = hn::CappedTag<std::uint64_t, 8>;
using HalfWords = hn::Rebind<std::uint32_t, Words>;
using Floats = hn::CappedTag<float, 16>;
using Ints = hn::RebindToSigned<Floats>;
using Bits = hn::RebindToUnsigned<Floats>;
using W = hn::Vec<Words>;
using F = hn::Vec<Floats>;

constexpr std::size_t kPairs = 64;  // at a time
constexpr std::size_t kMore = 16;   // places behind, so that vectors may be whole

// The words of pairs, then what they say of their points.
struct Draws {
  HWY_ALIGN std::array<std::array<std::uint32_t, kPairs + kMore>, 4> words;
  HWY_ALIGN std::array<float, 2 * (kPairs + kMore)> scatter;  // standard normal
  HWY_ALIGN std::array<float, 2 * (kPairs + kMore)> fate;     // whole numbers below 2^24
  HWY_ALIGN std::array<float, 2 * (kPairs + kMore)> range;    // [m]
};

// The products of the lower halves.
HWY_INLINE W multiply(W a, W b) {
#if HWY_TARGET == HWY_SCALAR
  const W low = hn::Set(Words(), 0xFFFFFFFFU);
  return hn::And(a, low) * hn::And(b, low);
#else
  const hn::Repartition<std::uint32_t, Words> halves;
  return hn::MulEven(hn::BitCast(halves, a), hn::BitCast(halves, b));
#endif
}

// `random_bits` of some samples: Philox4x32-10, see rng.cpp. Above 32 bits lanes hold garbage.
HWY_INLINE void draw_words(const RngKey& key, std::uint64_t first, std::size_t count, Draws& draws) {
  const Words d;
  const HalfWords half;
  const W ascending = hn::Iota(d, 0);
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    W c0 = hn::Add(ascending, hn::Set(d, first + i));
    W c1 = hn::ShiftLeft<16>(hn::And(hn::ShiftRight<32>(c0), hn::Set(d, 0xFFFFU)));
    W c2 = hn::Set(d, key.episode);
    W c3 = hn::Set(d, key.place());
    auto k0 = static_cast<std::uint32_t>(key.seed);
    auto k1 = static_cast<std::uint32_t>(key.seed >> 32);
    for (int round = 0; round < 10; ++round) {
      const W p0 = multiply(hn::Set(d, 0xD2511F53U), c0);
      const W p1 = multiply(hn::Set(d, 0xCD9E8D57U), c2);
      c0 = hn::Xor(hn::Xor(hn::ShiftRight<32>(p1), c1), hn::Set(d, k0));
      c1 = p1;
      c2 = hn::Xor(hn::Xor(hn::ShiftRight<32>(p0), c3), hn::Set(d, k1));
      c3 = p0;
      k0 += 0x9E3779B9U;
      k1 += 0xBB67AE85U;
    }
    hn::StoreU(hn::TruncateTo(half, c0), half, draws.words[0].data() + i);
    hn::StoreU(hn::TruncateTo(half, c1), half, draws.words[1].data() + i);
    hn::StoreU(hn::TruncateTo(half, c2), half, draws.words[2].data() + i);
    hn::StoreU(hn::TruncateTo(half, c3), half, draws.words[3].data() + i);
  }
}

// The middle of one of 2^23 equal steps from 0 to 1, exact.
HWY_INLINE F share_of(hn::Vec<Bits> word) {
  const Floats d;
  const F step = hn::ConvertTo(d, hn::BitCast(Ints(), hn::ShiftRight<9>(word)));
  return hn::Mul(hn::Add(step, hn::Set(d, 0.5F)), hn::Set(d, 0x1p-23F));
}

// The natural logarithm of normal numbers (Cephes, logf.c).
HWY_INLINE F logarithm(F x) {
  const Floats d;
  const Ints di;
  // x = m * 2^exponent, m between the roots of 1/2 and 2
  const auto bits = hn::Sub(hn::BitCast(di, x), hn::Set(di, 0x3F3504F3));
  const F exponent = hn::ConvertTo(d, hn::ShiftRight<23>(bits));
  const auto mantissa = hn::Add(hn::And(bits, hn::Set(di, 0x007FFFFF)), hn::Set(di, 0x3F3504F3));
  const F f = hn::Sub(hn::BitCast(d, mantissa), hn::Set(d, 1.0F));
  const F z = hn::Mul(f, f);
  F p = hn::Set(d, 7.0376836292e-2F);
  for (const float next : {-1.1514610310e-1F, 1.1676998740e-1F, -1.2420140846e-1F, 1.4249322787e-1F, -1.6668057665e-1F,
                           2.0000714765e-1F, -2.4999993993e-1F, 3.3333331174e-1F}) {
    p = hn::Add(hn::Mul(p, f), hn::Set(d, next));
  }
  F rest = hn::Mul(hn::Mul(p, f), z);
  rest = hn::Add(rest, hn::Mul(exponent, hn::Set(d, -2.12194440e-4F)));
  rest = hn::Sub(rest, hn::Mul(hn::Set(d, 0.5F), z));
  return hn::Add(hn::Add(f, rest), hn::Mul(exponent, hn::Set(d, 355.0F / 512.0F)));
}

struct SinCosF {
  F sin;
  F cos;
};

// Of so many turns, from 0 to 1 (polynomials: Cephes, sinf.c).
HWY_INLINE SinCosF sincos_of_turns(F turns) {
  const Floats d;
  const Ints di;
  const F quarters = hn::Mul(turns, hn::Set(d, 4.0F));
  const F nearest = hn::Floor(hn::Add(quarters, hn::Set(d, 0.5F)));
  const F z = hn::Mul(hn::Sub(quarters, nearest), hn::Set(d, std::numbers::pi_v<float> / 2.0F));
  const F zz = hn::Mul(z, z);
  F s = hn::Sub(hn::Set(d, 8.3321608736e-3F), hn::Mul(zz, hn::Set(d, 1.9515295891e-4F)));
  s = hn::Sub(hn::Mul(s, zz), hn::Set(d, 1.6666654611e-1F));
  s = hn::Add(z, hn::Mul(hn::Mul(s, zz), z));
  F c = hn::Sub(hn::Mul(zz, hn::Set(d, 2.443315711809948e-5F)), hn::Set(d, 1.388731625493765e-3F));
  c = hn::Add(hn::Mul(c, zz), hn::Set(d, 4.166664568298827e-2F));
  c = hn::Add(hn::Sub(hn::Set(d, 1.0F), hn::Mul(hn::Set(d, 0.5F), zz)), hn::Mul(hn::Mul(c, zz), zz));

  // every second quarter swaps the two; signs are the second bits of the quarter, and of the next
  const auto quarter = hn::ConvertTo(di, nearest);
  const auto one = hn::Set(di, 1);
  const auto swapped = hn::MaskFromVec(hn::BitCast(d, hn::ShiftRight<31>(hn::ShiftLeft<31>(quarter))));
  const auto sin_sign = hn::BitCast(d, hn::ShiftLeft<31>(hn::ShiftRight<1>(quarter)));
  const auto cos_sign = hn::BitCast(d, hn::ShiftLeft<31>(hn::ShiftRight<1>(hn::Add(quarter, one))));
  return {hn::Xor(hn::IfThenElse(swapped, c, s), sin_sign), hn::Xor(hn::IfThenElse(swapped, s, c), cos_sign)};
}

HWY_INLINE void interpret(std::size_t count, Draws& draws) {
  const Floats d;
  const Bits bits;
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const F size =
        hn::Sqrt(hn::Mul(hn::Set(d, -2.0F), logarithm(share_of(hn::LoadU(bits, draws.words[0].data() + i)))));
    const SinCosF direction = sincos_of_turns(share_of(hn::LoadU(bits, draws.words[1].data() + i)));
    hn::StoreInterleaved2(hn::Mul(size, direction.cos), hn::Mul(size, direction.sin), d, draws.scatter.data() + 2 * i);
    const auto fate = [&](std::size_t word) HWY_ATTR {
      const auto upper = hn::ShiftRight<8>(hn::LoadU(bits, draws.words[word].data() + i));
      return hn::ConvertTo(d, hn::BitCast(Ints(), upper));
    };
    hn::StoreInterleaved2(fate(2), fate(3), d, draws.fate.data() + 2 * i);
  }
}

// A vector of ranges [m] without what is drawn.
HWY_INLINE F plainly(F truth, const RangeNoise& noise) {
  const Floats d;
  const F far = hn::Set(d, noise.far);
  const F moved = hn::Min(hn::Add(truth, hn::Set(d, noise.bias)), far);
  const F measured = hn::IfThenElse(hn::Ge(truth, far), far, moved);
  return hn::IfThenZeroElse(hn::Lt(measured, hn::Set(d, noise.near)), measured);
}

void measure_plainly(const RangeNoise& noise, std::span<float> ranges) {
  const Floats d;
  const std::size_t lanes = hn::Lanes(d);
  std::size_t i = 0;
  for (; i + lanes <= ranges.size(); i += lanes) {
    hn::StoreU(plainly(hn::LoadU(d, ranges.data() + i), noise), d, ranges.data() + i);
  }
  if (i == ranges.size()) return;
  HWY_ALIGN std::array<float, hn::MaxLanes(Floats())> rest{};
  const auto left = ranges.subspan(i);
  std::ranges::copy(left, rest.begin());
  hn::Store(plainly(hn::Load(d, rest.data()), noise), d, rest.data());
  std::copy_n(rest.begin(), left.size(), left.begin());
}

void measure(const RngKey& key, std::uint64_t first, const RangeNoise& noise, std::span<float> ranges) {
  const Floats d;
  const F near = hn::Set(d, noise.near);
  const F far = hn::Set(d, noise.far);
  Draws draws;
  while (!ranges.empty()) {
    const std::size_t skipped = first % 2;
    const std::size_t count = std::min(2 * kPairs - skipped, ranges.size());
    const std::size_t pairs = (skipped + count + 1) / 2;
    draw_words(key, first / 2, pairs, draws);
    interpret(pairs, draws);

    std::copy_n(ranges.data(), count, draws.range.data());
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
      const F truth = hn::LoadU(d, draws.range.data() + i);
      const F scatter = hn::Mul(hn::Set(d, noise.sigma), hn::LoadU(d, draws.scatter.data() + skipped + i));
      const F moved = hn::Min(hn::Add(truth, hn::Add(hn::Set(d, noise.bias), scatter)), far);
      const F measured = hn::IfThenElse(hn::Ge(truth, far), far, moved);
      const auto dropped = hn::Lt(hn::LoadU(d, draws.fate.data() + skipped + i), hn::Set(d, 0x1p24F * noise.dropout));
      const auto lost = hn::Or(dropped, hn::Lt(measured, near));
      hn::StoreU(hn::IfThenZeroElse(lost, measured), d, draws.range.data() + i);
    }
    std::copy_n(draws.range.data(), count, ranges.data());
    ranges = ranges.subspan(count);
    first += count;
  }
}

void list_dropped(const RngKey& key, std::uint64_t first, std::size_t count, float dropout,
                  std::pmr::vector<std::size_t>& list) {
  const Floats d;
  const Bits bits;
  const F limit = hn::Set(d, 0x1p24F * dropout);
  Draws draws;
  const std::uint64_t end = first + count;
  for (std::uint64_t pair = first / 2; 2 * pair < end; pair += kPairs) {
    const std::size_t pairs = std::min<std::size_t>(kPairs, (end + 1) / 2 - pair);
    draw_words(key, pair, pairs, draws);
    for (std::size_t i = 0; i < pairs; i += hn::Lanes(d)) {
      const auto fate = [&](std::size_t word) HWY_ATTR {
        const auto upper = hn::ShiftRight<8>(hn::LoadU(bits, draws.words[word].data() + i));
        return hn::ConvertTo(d, hn::BitCast(Ints(), upper));
      };
      const F even = fate(2);
      const F odd = fate(3);
      if (hn::AllFalse(d, hn::Lt(hn::Min(even, odd), limit))) continue;
      hn::StoreInterleaved2(even, odd, d, draws.fate.data());
      for (std::size_t k = 0; k < 2 * hn::Lanes(d); ++k) {
        const std::uint64_t point = 2 * (pair + i) + k;
        if (draws.fate[k] < 0x1p24F * dropout && point >= first && point < end) list.push_back(point - first);
      }
    }
  }
}

}  // namespace threewe::models::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace threewe::models {

HWY_EXPORT(measure);
HWY_EXPORT(measure_plainly);
HWY_EXPORT(list_dropped);

void add_noise(const RngKey& key, std::uint64_t first, const RangeNoise& noise, std::span<float> ranges) {
  if (noise.sigma > 0.0F || noise.dropout > 0.0F) {
    HWY_DYNAMIC_DISPATCH(measure)(key, first, noise, ranges);
  } else {
    HWY_DYNAMIC_DISPATCH(measure_plainly)(noise, ranges);
  }
}

void append_dropped_points(const RngKey& key, std::uint64_t first, std::size_t count, float dropout,
                           std::pmr::vector<std::size_t>& list) {
  HWY_DYNAMIC_DISPATCH(list_dropped)(key, first, count, dropout, list);
}

}  // namespace threewe::models
#endif
