// e^x for vectors of float, with the same bits for every target. For kernels, after highway-inl.hpp.
#if defined(THREEWE_CORE_EXACT_EXP_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef THREEWE_CORE_EXACT_EXP_INL
#undef THREEWE_CORE_EXACT_EXP_INL
#else
#define THREEWE_CORE_EXACT_EXP_INL
#endif

#include <numbers>

HWY_BEFORE_NAMESPACE();
namespace threewe::exact::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// e^x, within 2 ulp for -87 <= x <= 88 (Cephes, expf.c).
template <class D, class V = hn::Vec<D>>
HWY_INLINE V exp(D d, V x) {
  const V whole = hn::Floor(hn::Add(hn::Mul(x, hn::Set(d, std::numbers::log2e_v<float>)), hn::Set(d, 0.5F)));
  // the natural logarithm of 2 in two parts, of which the first has few bits
  constexpr float kCoarse = 0.693359375F;  // NOLINT(modernize-use-std-numbers)
  constexpr float kRest = -2.12194440e-4F;
  const V rest = hn::Sub(hn::Sub(x, hn::Mul(whole, hn::Set(d, kCoarse))), hn::Mul(whole, hn::Set(d, kRest)));
  V p = hn::Add(hn::Mul(rest, hn::Set(d, 1.9875691500e-4F)), hn::Set(d, 1.3981999507e-3F));
  p = hn::Add(hn::Mul(p, rest), hn::Set(d, 8.3334519073e-3F));
  p = hn::Add(hn::Mul(p, rest), hn::Set(d, 4.1665795894e-2F));
  p = hn::Add(hn::Mul(p, rest), hn::Set(d, 1.6666665459e-1F));
  p = hn::Add(hn::Mul(p, rest), hn::Set(d, 5.0000001201e-1F));
  p = hn::Add(hn::Add(hn::Mul(p, hn::Mul(rest, rest)), rest), hn::Set(d, 1.0F));

  // times 2 to the whole: its exponent's bits
  const hn::RebindToSigned<D> di;
  const auto exponent = hn::ShiftLeft<23>(hn::Add(hn::ConvertTo(di, whole), hn::Set(di, 127)));
  return hn::Mul(p, hn::BitCast(d, exponent));
}

}  // namespace threewe::exact::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
