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

HWY_BEFORE_NAMESPACE();
namespace threewe::exact::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

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
