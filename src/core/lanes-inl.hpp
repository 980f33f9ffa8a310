// What a formula needs so that it can be written once, for a number and for a vector of them: V is double, or a vector
// of doubles. Every function gives each lane what the plain one gives a number, to the bit, also for -0.0 and NaN.
// For kernels, after highway-inl.hpp, or after <hwy/highway.h> for the plain form.
#if defined(THREEWE_CORE_LANES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef THREEWE_CORE_LANES_INL
#undef THREEWE_CORE_LANES_INL
#else
#define THREEWE_CORE_LANES_INL
#endif

#include <cmath>
#include <type_traits>

HWY_BEFORE_NAMESPACE();
namespace threewe::lanes::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

template <class V>
inline constexpr bool kIsNumber = std::is_same_v<V, double>;

/// The same number in every lane.
template <class V>
HWY_INLINE V number(double x) {
  if constexpr (kIsNumber<V>) {
    return x;
  } else {
    return hn::Set(hn::DFromV<V>(), x);
  }
}

/// `mask ? yes : no`.
template <class Mask, class V>
HWY_INLINE V where(Mask mask, V yes, V no) {
  if constexpr (kIsNumber<V>) {
    return mask ? yes : no;
  } else {
    return hn::IfThenElse(mask, yes, no);
  }
}

/// Masks over lanes of V.
template <class V, class Mask>
HWY_INLINE Mask both(Mask a, Mask b) {
  if constexpr (kIsNumber<V>) {
    return a && b;
  } else {
    return hn::And(a, b);
  }
}
template <class V, class Mask>
HWY_INLINE Mask either(Mask a, Mask b) {
  if constexpr (kIsNumber<V>) {
    return a || b;
  } else {
    return hn::Or(a, b);
  }
}
template <class V, class Mask>
HWY_INLINE Mask no(Mask mask) {
  if constexpr (kIsNumber<V>) {
    return !mask;
  } else {
    return hn::Not(mask);
  }
}
template <class V>
HWY_INLINE auto is_nan(V x) {
  if constexpr (kIsNumber<V>) {
    return std::isnan(x);
  } else {
    return hn::Ne(x, x);
  }
}

/// Whether a mask over lanes of V holds in any of them.
template <class V, class Mask>
HWY_INLINE bool any(Mask mask) {
  if constexpr (kIsNumber<V>) {
    return mask;
  } else {
    return !hn::AllFalse(hn::DFromV<V>(), mask);
  }
}

template <class V, class Mask>
HWY_INLINE bool all(Mask mask) {
  if constexpr (kIsNumber<V>) {
    return mask;
  } else {
    return hn::AllTrue(hn::DFromV<V>(), mask);
  }
}

template <class V>
HWY_INLINE V magnitude(V x) {
  if constexpr (kIsNumber<V>) {
    return std::fabs(x);
  } else {
    return hn::Abs(x);
  }
}

template <class V>
HWY_INLINE V root(V x) {
  if constexpr (kIsNumber<V>) {
    return std::sqrt(x);
  } else {
    return hn::Sqrt(x);
  }
}

template <class V>
HWY_INLINE V floor(V x) {
  if constexpr (kIsNumber<V>) {
    return std::floor(x);
  } else {
    return hn::Floor(x);
  }
}

template <class V>
HWY_INLINE V ceil(V x) {
  if constexpr (kIsNumber<V>) {
    return std::ceil(x);
  } else {
    return hn::Ceil(x);
  }
}

/// std::max and std::min; hardware has its own ideas about zeros and NaN.
template <class V>
HWY_INLINE V larger(V a, V b) {
  return where(a < b, b, a);
}
template <class V>
HWY_INLINE V smaller(V a, V b) {
  return where(b < a, b, a);
}
/// std::clamp.
template <class V>
HWY_INLINE V clamp(V x, V low, V high) {
  return where(x < low, low, where(high < x, high, x));
}

}  // namespace threewe::lanes::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
