// Vector functions whose bits are the same for every target: products and sums unfused, no approximate reciprocals.
// For kernels, after highway-inl.hpp.
#if defined(THREEWE_CORE_EXACT_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef THREEWE_CORE_EXACT_INL
#undef THREEWE_CORE_EXACT_INL
#else
#define THREEWE_CORE_EXACT_INL
#endif

#include <cstddef>
#include <numbers>

#include "core/exact.hpp"
#include "core/lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace threewe::exact::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// pi/4 in four parts of decreasing size, the first three so short that their multiples up to 2^24 are exact: even next
// to a multiple of pi the remainder keeps all of its digits (the method of Cephes, sin.c, with one part more).
inline constexpr double kQuarterPi1 = 7.85398125648498535156e-1;
inline constexpr double kQuarterPi2 = 3.77489470793079817668e-8;
inline constexpr double kQuarterPi3 = 2.69515142379756e-15;
inline constexpr double kQuarterPi4 = 5.281499533493714e-24;

/// What is left of |angle| after `octants` of them, an even number: between -pi/4 and pi/4.
template <class V>
HWY_INLINE V reduce(V angle, V octants) {
  using lanes::HWY_NAMESPACE::number;
  return (((angle - octants * number<V>(kQuarterPi1)) - octants * number<V>(kQuarterPi2)) -
          octants * number<V>(kQuarterPi3)) -
         octants * number<V>(kQuarterPi4);
}

/// Minimax polynomials on [-pi/4, pi/4] (Cephes, sin.c).
template <class V>
HWY_INLINE V sin_polynomial(V z) {
  using lanes::HWY_NAMESPACE::number;
  const V zz = z * z;
  V p = number<V>(1.58962301576546568060e-10) * zz - number<V>(2.50507477628578072866e-8);
  p = p * zz + number<V>(2.75573136213857245213e-6);
  p = p * zz - number<V>(1.98412698295895385996e-4);
  p = p * zz + number<V>(8.33333333332211858878e-3);
  p = p * zz - number<V>(1.66666666666666307295e-1);
  return z + z * zz * p;
}
template <class V>
HWY_INLINE V cos_polynomial(V z) {
  using lanes::HWY_NAMESPACE::number;
  const V zz = z * z;
  V p = number<V>(-1.13585365213876817300e-11) * zz + number<V>(2.08757008419747316778e-9);
  p = p * zz - number<V>(2.75573141792967388112e-7);
  p = p * zz + number<V>(2.48015872888517045348e-5);
  p = p * zz - number<V>(1.38888888888730564116e-3);
  p = p * zz + number<V>(4.16666666666665929218e-2);
  return number<V>(1.0) - number<V>(0.5) * zz + zz * zz * p;
}

template <class V>
struct SinCosOf {
  V sin;
  V cos;
};

/// exact::sincos, lane by lane and to the bit, for |angle| < 1e9.
template <class V>
HWY_INLINE SinCosOf<V> sincos(V angle) {
  if constexpr (lanes::HWY_NAMESPACE::kIsNumber<V>) {
    const SinCos both = threewe::exact::sincos(angle);
    return {both.sin, both.cos};
  } else {
    using lanes::HWY_NAMESPACE::number;
    const V size = hn::Abs(angle);
    const V sign = hn::Xor(angle, size);

    // the quadrant around an axis that it lies in; nearly always all lanes lie in the first
    if (lanes::HWY_NAMESPACE::all<V>(size < number<V>(0.78))) {
      return {hn::Xor(sin_polynomial(size), sign), cos_polynomial(size)};
    }
    const V quadrant = hn::Floor(number<V>(0.5) * (hn::Floor(size / number<V>(kPi / 4)) + number<V>(1.0)));
    const V z = reduce(size, number<V>(2.0) * quadrant);
    const V s = sin_polynomial(z);
    const V c = cos_polynomial(z);

    // every second quadrant swaps the two
    const V half = number<V>(0.5) * quadrant;
    const auto swapped = half > hn::Floor(half);
    const V quarter = number<V>(0.25) * quadrant;
    const V turn = quarter - hn::Floor(quarter);  // 0, 1/4, 1/2 or 3/4
    const V minus = number<V>(-0.0);
    const V sin_sign = hn::IfThenElseZero(turn > number<V>(0.375), minus);
    const V cos_sign = hn::IfThenElseZero(hn::And(turn > number<V>(0.125), turn < number<V>(0.625)), minus);
    return {hn::Xor(hn::Xor(hn::IfThenElse(swapped, c, s), sin_sign), sign),
            hn::Xor(hn::IfThenElse(swapped, s, c), cos_sign)};
  }
}

/// The angle of (x, y) [rad] in [-pi, pi], within 4e-7; finite, but arbitrary, at (0, 0).
template <class D, class V = hn::Vec<D>>
HWY_INLINE V atan2(D d, V y, V x) {
  const V abs_x = hn::Abs(x);
  const V abs_y = hn::Abs(y);
  const V small = hn::Min(abs_x, abs_y);
  const V large = hn::Max(hn::Max(abs_x, abs_y), hn::Set(d, 1e-30F));

  // small / large in [0, 1], or where it is above tan(pi/8), the ratio turned back by pi/4
  const auto turned = hn::Gt(small, hn::Mul(large, hn::Set(d, 0.41421356F)));
  const V numerator = hn::IfThenElse(turned, hn::Sub(small, large), small);
  const V denominator = hn::IfThenElse(turned, hn::Add(small, large), large);
  const V t = hn::Div(numerator, denominator);

  // the polynomial of Cephes, atanf.c
  const V z = hn::Mul(t, t);
  V p = hn::Sub(hn::Mul(z, hn::Set(d, 8.05374449538e-2F)), hn::Set(d, 1.38776856032e-1F));
  p = hn::Add(hn::Mul(p, z), hn::Set(d, 1.99777106478e-1F));
  p = hn::Sub(hn::Mul(p, z), hn::Set(d, 3.33329491539e-1F));
  const V octant = hn::IfThenElseZero(turned, hn::Set(d, std::numbers::pi_v<float> / 4.0F));
  V angle = hn::Add(octant, hn::Add(t, hn::Mul(t, hn::Mul(z, p))));

  // back to the quadrant
  angle = hn::IfThenElse(hn::Gt(abs_y, abs_x), hn::Sub(hn::Set(d, std::numbers::pi_v<float> / 2.0F), angle), angle);
  angle = hn::IfThenElse(hn::Lt(x, hn::Zero(d)), hn::Sub(hn::Set(d, std::numbers::pi_v<float>), angle), angle);
  return hn::CopySign(angle, y);
}

/// The sum of `count` numbers in one fixed order: 16 partial sums, then a tree.
inline float sum(const float* values, std::size_t count) {
  const hn::CappedTag<float, 16> d;
  HWY_ALIGN float partial[16] = {};
  std::size_t i = 0;
  for (; i + 16 <= count; i += 16) {
    for (std::size_t j = 0; j < 16; j += hn::Lanes(d)) {
      hn::Store(hn::Add(hn::Load(d, partial + j), hn::LoadU(d, values + i + j)), d, partial + j);
    }
  }
  for (std::size_t j = 0; i + j < count; ++j) partial[j] = partial[j] + values[i + j];
  for (std::size_t half = 8; half > 0; half /= 2) {
    for (std::size_t j = 0; j < half; ++j) partial[j] = partial[j] + partial[j + half];
  }
  return partial[0];
}

}  // namespace threewe::exact::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
