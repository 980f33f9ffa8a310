// Elementary functions whose bits are the same on every machine: no libm, no fused multiply-add.
// Only +, -, *, / and square root are used, each of which IEEE 754 rounds in one way alone.
#pragma once

#include <cmath>
#include <numbers>
#include <span>

namespace threewe::exact {

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kHalfPi = 0.5 * kPi;

/// Correctly rounded by IEEE 754, hence the one function of <cmath> that exact code may call.
inline double sqrt(double x) { return std::sqrt(x); }
inline float sqrt(float x) { return std::sqrt(x); }

struct SinCos {
  double sin;
  double cos;
};

/// Sine and cosine of `angle` [rad]; within 2 ulp for |angle| < 1e5.
SinCos sincos(double angle);
double sin(double angle);
double cos(double angle);
/// The angle of (x, y) in [-pi, pi]; within 2 ulp. atan2(0, 0) is 0.
double atan2(double y, double x);
/// e^x within 2 ulp; 0 below -745, infinity above 709.78.
double exp(double x);
/// The natural logarithm within 2 ulp; -infinity at 0, NaN below.
double log(double x);
/// sqrt(x^2 + y^2), without guarding against overflow.
inline double hypot(double x, double y) { return sqrt(x * x + y * y); }

/// The sum of many numbers, in one fixed order on every machine: 16 partial sums, then a tree.
float sum(std::span<const float> values);

}  // namespace threewe::exact
