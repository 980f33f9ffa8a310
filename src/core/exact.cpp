#include "core/exact.hpp"

#include <bit>
#include <cstdint>
#include <limits>

#include <hwy/highway.h>

#include "core/exact-inl.hpp"

namespace threewe::exact {
namespace {

// atan on [0, infinity) (Cephes, atan.c).
double atan_positive(double x) {
  constexpr double kTan3Pi8 = 2.41421356237309504880;
  constexpr double kMoreBits = 6.123233995736765886130e-17;
  double base = 0.0;
  double correction = 0.0;
  if (x > kTan3Pi8) {
    base = kPi / 2;
    correction = kMoreBits;
    x = -1.0 / x;
  } else if (x > 0.66) {
    base = kPi / 4;
    correction = 0.5 * kMoreBits;
    x = (x - 1.0) / (x + 1.0);
  }
  const double z = x * x;
  const double p =
      (((-8.750608600031904122785e-1 * z - 1.615753718733365076637e1) * z - 7.500855792314704667340e1) * z -
       1.228866684490136173410e2) *
          z -
      6.485021904942025371773e1;
  const double q =
      ((((z + 2.485846490142306297962e1) * z + 1.650270098316988542046e2) * z + 4.328810604912902668951e2) * z +
       4.853903996359136964868e2) *
          z +
      1.945506571482613964425e2;
  return base + (x * (z * p / q) + x + correction);
}

}  // namespace

SinCos sincos(double angle) {
  const double magnitude = std::fabs(angle);
  if (!(magnitude < 1e9)) {
    return {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN()};
  }

  // the octant, rounded up to an even one, so that the remainder lies in [-pi/4, pi/4]
  auto octant = static_cast<std::int64_t>(magnitude / (kPi / 4));
  octant += octant & 1;
  const auto n = static_cast<double>(octant);
  const double z = HWY_NAMESPACE::reduce(magnitude, n);

  // every second quadrant swaps the two polynomials
  const double s = HWY_NAMESPACE::sin_polynomial(z);
  const double c = HWY_NAMESPACE::cos_polynomial(z);
  double sine = 0.0;
  double cosine = 0.0;
  switch (octant & 7) {
    case 0: sine = s, cosine = c; break;
    case 2: sine = c, cosine = -s; break;
    case 4: sine = -s, cosine = -c; break;
    default: sine = -c, cosine = s; break;
  }
  return {std::signbit(angle) ? -sine : sine, cosine};
}

double sin(double angle) { return sincos(angle).sin; }
double cos(double angle) { return sincos(angle).cos; }

double atan2(double y, double x) {
  if (std::isnan(x) || std::isnan(y)) return std::numeric_limits<double>::quiet_NaN();
  if (y == 0.0) return x < 0.0 ? std::copysign(kPi, y) : 0.0;
  const double angle = x == 0.0 ? kPi / 2 : atan_positive(std::fabs(y / x));
  return std::copysign(x < 0.0 ? kPi - angle : angle, y);
}

// Argument reduction and rational approximation of fdlibm's e_exp.c.
double exp(double x) {
  if (std::isnan(x)) return x;
  if (x > 709.78) return std::numeric_limits<double>::infinity();
  if (x < -745.0) return 0.0;
  constexpr double kLn2High = 0x1.62e42fee00000p-1;  // NOLINT(modernize-use-std-numbers): its first 33 bits
  constexpr double kLn2Low = 1.90821492927058770002e-10;

  // x = k ln 2 + r with |r| <= ln 2 / 2, r kept as high - low
  const double k = std::floor(x / std::numbers::ln2 + 0.5);
  const double high = x - k * kLn2High;
  const double low = k * kLn2Low;
  const double r = high - low;
  const double t = r * r;
  const double c =
      r -
      t * (1.66666666666666019037e-01 +
           t * (-2.77777777770155933842e-03 +
                t * (6.61375632143793436117e-05 + t * (-1.65339022054652515390e-06 + t * 4.13813679705723846039e-08))));
  const double y = 1.0 - ((low - (r * c) / (2.0 - c)) - high);

  // times 2^k, in two steps so that no intermediate leaves the range of double
  const auto exponent = static_cast<std::int64_t>(k);
  const auto power = [](std::int64_t e) { return std::bit_cast<double>((e + 1023) << 52); };
  return y * power(exponent / 2) * power(exponent - exponent / 2);
}

// fdlibm's e_log.c.
double log(double x) {
  if (std::isnan(x) || x < 0.0) return std::numeric_limits<double>::quiet_NaN();
  if (x == 0.0) return -std::numeric_limits<double>::infinity();
  if (std::isinf(x)) return x;

  // x = 2^k m with m in [sqrt(1/2), sqrt(2))
  double k = 0.0;
  if (x < std::numeric_limits<double>::min()) {
    x = x * 18014398509481984.0;  // 2^54
    k = -54.0;
  }
  const auto bits = std::bit_cast<std::uint64_t>(x);
  k += static_cast<double>(static_cast<std::int64_t>(bits >> 52) - 1023);
  auto m = std::bit_cast<double>((bits & 0x000fffffffffffffULL) | 0x3ff0000000000000ULL);
  if (m > std::numbers::sqrt2) {
    m = 0.5 * m;
    k += 1.0;
  }

  constexpr double kLn2High = 0x1.62e42fee00000p-1;  // NOLINT(modernize-use-std-numbers): its first 33 bits
  constexpr double kLn2Low = 1.90821492927058770002e-10;
  const double f = m - 1.0;
  const double s = f / (2.0 + f);
  const double z = s * s;
  double r = 1.479819860510658591e-01;
  for (const double next : {1.531383769920937332e-01, 1.818357216161805012e-01, 2.222219843214978396e-01,
                            2.857142874366239149e-01, 3.999999999940941908e-01, 6.666666666666735130e-01}) {
    r = r * z + next;
  }
  r = z * r;
  const double half_square = 0.5 * f * f;
  return k * kLn2High - ((half_square - (s * (half_square + r) + k * kLn2Low)) - f);
}

}  // namespace threewe::exact
