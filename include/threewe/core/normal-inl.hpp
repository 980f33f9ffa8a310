// The quantile of the normal distribution (Wichura 1988, AS 241) and the logarithm it needs, for a number and for a
// vector of them, with the same bits. For kernels, after highway-inl.hpp.
#if defined(THREEWE_CORE_NORMAL_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef THREEWE_CORE_NORMAL_INL
#undef THREEWE_CORE_NORMAL_INL
#else
#define THREEWE_CORE_NORMAL_INL
#endif

#include <array>
#include <cstddef>

#include "threewe/core/lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace threewe::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// A polynomial by Horner's rule, the highest power first.
template <class V, std::size_t kCount>
HWY_INLINE V polynomial(const std::array<double, kCount>& coefficients, V x) {
  using lanes::HWY_NAMESPACE::number;
  V value = number<V>(coefficients[0]);
  for (std::size_t i = 1; i < kCount; ++i) value = value * x + number<V>(coefficients[i]);
  return value;
}

/// The farthest from 1/2 that the middle of the distribution reaches, 85 % of it.
inline constexpr double kNormalMiddle = 0.425;

/// The quantile at q + 1/2, for |q| up to kNormalMiddle.
template <class V>
HWY_INLINE V normal_middle(V q) {
  using lanes::HWY_NAMESPACE::number;
  const V r = number<V>(0.180625) - q * q;
  const V numerator =
      polynomial(std::array{2509.0809287301226727, 33430.575583588128105, 67265.770927008700853, 45921.953931549871457,
                            13731.693765509461125, 1971.5909503065514427, 133.14166789178437745, 3.387132872796366608},
                 r);
  const V denominator =
      polynomial(std::array{5226.495278852545925, 28729.085735721942674, 39307.89580009271061, 21213.794301586595867,
                            5394.1960214247511077, 687.1870074920579083, 42.313330701600911252, 1.0},
                 r);
  return q * numerator / denominator;
}

/// The farthest that the near tails reach, as the root of -log of what lies beyond.
inline constexpr double kNormalTail = 5.0;

/// How far out a share of exp(-r^2) lies beyond, for r up to kNormalTail.
template <class V>
HWY_INLINE V normal_tail(V root) {
  using lanes::HWY_NAMESPACE::number;
  const V r = root - number<V>(1.6);
  return polynomial(std::array{7.7454501427834140764e-4, 0.0227238449892691845833, 0.24178072517745061177,
                               1.27045825245236838258, 3.64784832476320460504, 5.7694972214606914055,
                               4.6303378461565452959, 1.42343711074968357734},
                    r) /
         polynomial(std::array{1.05075007164441684324e-9, 5.475938084995344946e-4, 0.0151986665636164571966,
                               0.14810397642748007459, 0.68976733498510000455, 1.6763848301838038494,
                               2.05319162663775882187, 1.0},
                    r);
}

/// log(2^k m) for m in [sqrt(1/2), sqrt(2)) (the polynomial of fdlibm's e_log.c).
template <class V>
HWY_INLINE V log_of_parts(V k, V m) {
  using lanes::HWY_NAMESPACE::number;
  constexpr double kLn2High = 0x1.62e42fee00000p-1;  // NOLINT(modernize-use-std-numbers): its first 33 bits
  constexpr double kLn2Low = 1.90821492927058770002e-10;
  const V f = m - number<V>(1.0);
  const V s = f / (number<V>(2.0) + f);
  const V z = s * s;
  const V r = z * polynomial(std::array{1.479819860510658591e-01, 1.531383769920937332e-01, 1.818357216161805012e-01,
                                        2.222219843214978396e-01, 2.857142874366239149e-01, 3.999999999940941908e-01,
                                        6.666666666666735130e-01},
                             z);
  const V half_square = number<V>(0.5) * f * f;
  return k * number<V>(kLn2High) - ((half_square - (s * (half_square + r) + k * number<V>(kLn2Low))) - f);
}

}  // namespace threewe::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
