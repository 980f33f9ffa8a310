// The library's elementary functions against libm in long double, in units in the last place.
#include "core/exact.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <random>

namespace {

namespace exact = threewe::exact;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr int kCases = 20000;

// The distance between a value and the true one, in units of the last place of the true one.
double ulps(double value, long double truth) {
  const double rounded = static_cast<double>(truth);
  if (value == rounded) return 0.0;
  const double unit = std::nextafter(std::fabs(rounded), kInfinity) - std::fabs(rounded);
  return static_cast<double>(std::fabs(static_cast<long double>(value) - truth) / static_cast<long double>(unit));
}

struct Uniform {
  std::mt19937_64 bits;
  double operator()(double low, double high) {
    return low + (high - low) * static_cast<double>(bits() >> 11) * 0x1p-53;
  }
  // uniform in the exponent, either sign
  double any_magnitude(double low, double high) {
    const double magnitude = std::exp((*this)(std::log(low), std::log(high)));
    return bits() & 1 ? magnitude : -magnitude;
  }
};

TEST_CASE("sine and cosine are within 2 ulp below 1e5 rad") {
  Uniform uniform{std::mt19937_64(1)};
  double worst = 0.0;
  for (int i = 0; i < kCases; ++i) {
    const double angle = i % 2 ? uniform(-10.0, 10.0) : uniform.any_magnitude(1e-12, 1e5);
    const auto [s, c] = exact::sincos(angle);
    CAPTURE(angle);
    const double error = std::max(ulps(s, std::sin(static_cast<long double>(angle))),
                                  ulps(c, std::cos(static_cast<long double>(angle))));
    worst = std::max(worst, error);
    REQUIRE(error <= 2.0);
    REQUIRE(exact::sin(angle) == s);
    REQUIRE(exact::cos(angle) == c);
  }
  MESSAGE("sincos: worst error ", worst, " ulp");
}

TEST_CASE("sine and cosine near multiples of a right angle") {
  for (int k = -1000; k <= 1000; ++k) {
    for (const double offset : {-1e-3, -1e-9, 0.0, 1e-9, 1e-3}) {
      const double angle = k * exact::kPi / 2 + offset;
      CAPTURE(angle);
      const auto [s, c] = exact::sincos(angle);
      REQUIRE(ulps(s, std::sin(static_cast<long double>(angle))) <= 2.0);
      REQUIRE(ulps(c, std::cos(static_cast<long double>(angle))) <= 2.0);
    }
  }
}

TEST_CASE("sine is odd, cosine even, and their squares sum to 1") {
  Uniform uniform{std::mt19937_64(2)};
  for (int i = 0; i < kCases; ++i) {
    const double angle = uniform(-100.0, 100.0);
    CAPTURE(angle);
    const auto [s, c] = exact::sincos(angle);
    const auto mirrored = exact::sincos(-angle);
    REQUIRE(mirrored.sin == -s);
    REQUIRE(mirrored.cos == c);
    REQUIRE(s * s + c * c == doctest::Approx(1.0).epsilon(1e-15));
  }
}

TEST_CASE("sine and cosine of special values") {
  CHECK(exact::sin(0.0) == 0.0);
  CHECK(std::signbit(exact::sin(-0.0)));
  CHECK(exact::cos(0.0) == 1.0);
  CHECK(std::isnan(exact::sin(kNaN)));
  CHECK(std::isnan(exact::cos(kInfinity)));
  CHECK(std::isnan(exact::sin(-kInfinity)));
}

TEST_CASE("atan2 is within 2 ulp in every quadrant and at every ratio") {
  Uniform uniform{std::mt19937_64(3)};
  double worst = 0.0;
  for (int i = 0; i < kCases; ++i) {
    const double y = uniform.any_magnitude(1e-9, 1e9);
    const double x = i % 2 ? uniform.any_magnitude(1e-9, 1e9) : y * uniform(-3.0, 3.0);
    CAPTURE(y);
    CAPTURE(x);
    const double error = ulps(exact::atan2(y, x), std::atan2(static_cast<long double>(y), static_cast<long double>(x)));
    worst = std::max(worst, error);
    REQUIRE(error <= 2.0);
  }
  MESSAGE("atan2: worst error ", worst, " ulp");
}

TEST_CASE("atan2 turns back what sincos made") {
  Uniform uniform{std::mt19937_64(4)};
  for (int i = 0; i < kCases; ++i) {
    const double angle = uniform(-exact::kPi, exact::kPi);
    CAPTURE(angle);
    const auto [s, c] = exact::sincos(angle);
    REQUIRE(exact::atan2(s, c) == doctest::Approx(angle).epsilon(1e-15));
  }
}

TEST_CASE("atan2 on the axes, at zero and at infinity, as libm has it") {
  for (const double y : {0.0, -0.0, 1.0, -1.0, 1e-300, -1e300, kInfinity, -kInfinity}) {
    for (const double x : {0.0, 1.0, -1.0, 1e300, -1e-300, kInfinity, -kInfinity}) {
      if (std::isinf(x) && std::isinf(y)) continue;  // nothing asks for it
      CAPTURE(y);
      CAPTURE(x);
      CHECK(exact::atan2(y, x) == doctest::Approx(std::atan2(y, x)).epsilon(1e-15));
    }
  }
  CHECK(exact::atan2(0.0, 0.0) == 0.0);
  CHECK(exact::atan2(0.0, -0.0) == 0.0);
  CHECK(exact::atan2(0.0, -1.0) == exact::kPi);
  CHECK(exact::atan2(-0.0, -1.0) == -exact::kPi);
  CHECK(std::isnan(exact::atan2(kNaN, 1.0)));
  CHECK(std::isnan(exact::atan2(1.0, kNaN)));
}

TEST_CASE("exp is within 2 ulp over its whole range") {
  Uniform uniform{std::mt19937_64(5)};
  double worst = 0.0;
  for (int i = 0; i < kCases; ++i) {
    const double x = i % 2 ? uniform(-708.0, 709.7) : uniform.any_magnitude(1e-18, 1.0);
    CAPTURE(x);
    const double error = ulps(exact::exp(x), std::exp(static_cast<long double>(x)));
    worst = std::max(worst, error);
    REQUIRE(error <= 2.0);
  }
  MESSAGE("exp: worst error ", worst, " ulp");
}

TEST_CASE("exp of special values and where doubles become subnormal") {
  CHECK(exact::exp(0.0) == 1.0);
  CHECK(exact::exp(-0.0) == 1.0);
  CHECK(exact::exp(-kInfinity) == 0.0);
  CHECK(exact::exp(-746.0) == 0.0);
  CHECK(exact::exp(kInfinity) == kInfinity);
  CHECK(exact::exp(710.0) == kInfinity);
  CHECK(std::isnan(exact::exp(kNaN)));
  for (double x = -744.9; x < -708.0; x += 0.37) {
    CAPTURE(x);
    CHECK(std::fabs(exact::exp(x) - std::exp(x)) <=
          2 * std::numeric_limits<double>::denorm_min() + 1e-15 * std::exp(x));
  }
}

TEST_CASE("log is within 2 ulp over its whole range") {
  Uniform uniform{std::mt19937_64(6)};
  double worst = 0.0;
  for (int i = 0; i < kCases; ++i) {
    const double x = i % 2 ? std::fabs(uniform.any_magnitude(1e-300, 1e300)) : uniform(0.5, 2.0);
    CAPTURE(x);
    const double error = ulps(exact::log(x), std::log(static_cast<long double>(x)));
    worst = std::max(worst, error);
    REQUIRE(error <= 2.0);
  }
  MESSAGE("log: worst error ", worst, " ulp");
}

TEST_CASE("log of special values") {
  CHECK(exact::log(1.0) == 0.0);
  CHECK(exact::log(0.0) == -kInfinity);
  CHECK(exact::log(kInfinity) == kInfinity);
  CHECK(std::isnan(exact::log(-1.0)));
  CHECK(std::isnan(exact::log(-kInfinity)));
  CHECK(std::isnan(exact::log(kNaN)));
  CHECK(exact::log(std::numeric_limits<double>::denorm_min()) ==
        doctest::Approx(std::log(std::numeric_limits<double>::denorm_min())).epsilon(1e-15));
}

TEST_CASE("exp and log undo each other") {
  Uniform uniform{std::mt19937_64(7)};
  for (int i = 0; i < kCases; ++i) {
    const double x = uniform(-50.0, 50.0);
    CAPTURE(x);
    REQUIRE(exact::log(exact::exp(x)) == doctest::Approx(x).epsilon(1e-14));
  }
}

TEST_CASE("hypot and sqrt") {
  CHECK(exact::hypot(3.0, 4.0) == 5.0);
  CHECK(exact::hypot(-5.0, 12.0) == 13.0);
  CHECK(exact::hypot(0.0, 0.0) == 0.0);
  CHECK(exact::sqrt(2.0) == std::sqrt(2.0));
  CHECK(exact::sqrt(2.0F) == std::sqrt(2.0F));
}

}  // namespace
