// Each lane is a point. Most lie in the middle of the distribution; the others are gathered, and drawn as vectors too.
#include "models/lidar_noise.hpp"

#include <numbers>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "models/lidar_noise.cpp"
#include "threewe/core/highway-inl.hpp"
//
#include "threewe/core/exact.hpp"
#include "threewe/core/normal-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace threewe::models::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::CappedTag<double, 8>;
using Words = hn::RebindToUnsigned<Doubles>;
using V = hn::Vec<Doubles>;
using W = hn::Vec<Words>;

HWY_INLINE W low_half(W a) { return hn::And(a, hn::Set(Words(), 0xFFFFFFFFU)); }

// The products of the lower halves.
HWY_INLINE W multiply(W a, W b) {
#if HWY_TARGET == HWY_SCALAR
  return low_half(a) * low_half(b);
#else
  const hn::Repartition<std::uint32_t, Words> halves;
  return hn::MulEven(hn::BitCast(halves, a), hn::BitCast(halves, b));
#endif
}

// A whole number below 2^53.
HWY_INLINE V to_double(W n) {
  const Doubles d;
  const V high = hn::BitCast(d, hn::Or(hn::ShiftRight<32>(n), hn::Set(Words(), 0x4530000000000000U)));
  const V low = hn::BitCast(d, hn::Or(low_half(n), hn::Set(Words(), 0x4330000000000000U)));
  return (high - hn::Set(d, 0x1p84)) + (low - hn::Set(d, 0x1p52));
}

struct PhiloxOf {
  W c0, c1, c2, c3;  // garbage above 32 bits
};

// Philox4x32-10, see rng.cpp.
HWY_INLINE PhiloxOf philox(PhiloxOf c, std::uint64_t seed) {
  const Words d;
  auto k0 = static_cast<std::uint32_t>(seed);
  auto k1 = static_cast<std::uint32_t>(seed >> 32);
  for (int round = 0; round < 10; ++round) {
    const W p0 = multiply(hn::Set(d, 0xD2511F53U), c.c0);
    const W p1 = multiply(hn::Set(d, 0xCD9E8D57U), c.c2);
    c = {hn::Xor(hn::Xor(hn::ShiftRight<32>(p1), c.c1), hn::Set(d, k0)), p1,
         hn::Xor(hn::Xor(hn::ShiftRight<32>(p0), c.c3), hn::Set(d, k1)), p0};
    k0 += 0x9E3779B9U;
    k1 += 0xBB67AE85U;
  }
  return c;
}

// The logarithm of positive normal numbers, as exact::log.
HWY_INLINE V logarithm(V x) {
  const Doubles d;
  const Words dw;
  const W bits = hn::BitCast(dw, x);
  const W biased = hn::Or(hn::ShiftRight<52>(bits), hn::Set(dw, 0x4330000000000000U));
  const V exponent = hn::BitCast(d, biased) - hn::Set(d, 0x1p52 + 1023.0);
  const W fraction = hn::And(bits, hn::Set(dw, 0x000FFFFFFFFFFFFFU));
  const V m = hn::BitCast(d, hn::Or(fraction, hn::Set(dw, 0x3FF0000000000000U)));
  const auto above = hn::Gt(m, hn::Set(d, std::numbers::sqrt2));
  return threewe::HWY_NAMESPACE::log_of_parts(hn::IfThenElse(above, exponent + hn::Set(d, 1.0), exponent),
                                              hn::IfThenElse(above, hn::Set(d, 0.5) * m, m));
}

// What lies outside the middle of the distribution.
struct Tails {
  HWY_ALIGN double p[kDrawn];
  HWY_ALIGN double root[kDrawn];
  HWY_ALIGN double out[kDrawn];
  std::size_t point[kDrawn];
  std::size_t count = 0;
};

void draw_tails(Tails& tails, PointDraws& draws) {
  const Doubles d;
  const std::size_t lanes = hn::Lanes(d);
  for (std::size_t i = tails.count; i % lanes != 0; ++i) tails.p[i] = 0.01;  // so that the last vector is full
  for (std::size_t i = 0; i < tails.count; i += lanes) {
    const V p = hn::Load(d, tails.p + i);
    const auto below = hn::Lt(p, hn::Set(d, 0.5));
    const V root = hn::Sqrt(hn::Neg(logarithm(hn::IfThenElse(below, p, hn::Set(d, 1.0) - p))));
    const V size = threewe::HWY_NAMESPACE::normal_tail(root);
    hn::Store(root, d, tails.root + i);
    hn::Store(hn::IfThenElse(below, hn::Neg(size), size), d, tails.out + i);
  }
  for (std::size_t i = 0; i < tails.count; ++i) {
    const bool near = tails.root[i] <= threewe::HWY_NAMESPACE::kNormalTail;  // all but one in 10^11
    draws.scatter[tails.point[i]] = near ? tails.out[i] : normal_quantile(tails.p[i]);
  }
}

void draw(const RngKey& key, std::uint64_t first, std::size_t count, PointDraws& draws) {
  const Doubles d;
  const Words dw;
  const std::size_t lanes = hn::Lanes(d);
  const auto place = static_cast<std::uint32_t>((key.robot & 0xFFFU) << 20 | (key.sensor & 0xFFFU) << 8 |
                                                (static_cast<std::uint32_t>(key.stream) & 0xFFU));
  const W ascending = hn::Iota(dw, 0);
  HWY_ALIGN double p[kDrawn];
  for (std::size_t i = 0; i < count; i += lanes) {
    const W sample = ascending + hn::Set(dw, first + i);
    const W high = hn::ShiftLeft<16>(hn::And(hn::ShiftRight<32>(sample), hn::Set(dw, 0xFFFFU)));
    const PhiloxOf bits = philox({sample, high, hn::Set(dw, key.episode), hn::Set(dw, place)}, key.seed);
    const W wide = hn::Or(hn::ShiftLeft<32>(bits.c0), low_half(bits.c1));
    const V share = to_double(hn::ShiftRight<11>(wide)) * hn::Set(d, 0x1p-53) + hn::Set(d, 0x1p-54);
    hn::Store(share, d, p + i);
    hn::Store(threewe::HWY_NAMESPACE::normal_middle(share - hn::Set(d, 0.5)), d, draws.scatter + i);
    hn::Store(low_half(bits.c2), dw, draws.fate + i);
  }
  Tails tails;
  for (std::size_t i = 0; i < count; ++i) {
    tails.p[tails.count] = p[i];
    tails.point[tails.count] = i;
    const double q = p[i] - 0.5;
    tails.count += q > threewe::HWY_NAMESPACE::kNormalMiddle || q < -threewe::HWY_NAMESPACE::kNormalMiddle ? 1 : 0;
  }
  draw_tails(tails, draws);
}

}  // namespace threewe::models::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace threewe::models {

HWY_EXPORT(draw);

void draw_points(const RngKey& key, std::uint64_t first, std::size_t count, PointDraws& draws) {
  HWY_DYNAMIC_DISPATCH(draw)(key, first, count, draws);
}

}  // namespace threewe::models
#endif
