#include "hardware/limits.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/rng.hpp"

using namespace threewe;

namespace {

constexpr Limits kLimits{.linear = 1.2, .angular = 3.0};

// Wide enough for every square: what a double can hold, a long double can hold the square of.
Velocity oracle(const Velocity& v) {
  static_assert(std::numeric_limits<long double>::max_exponent > 2 * std::numeric_limits<double>::max_exponent);
  const long double x = v.vx;
  const long double y = v.vy;
  const long double scale = std::min(1.0L, kLimits.linear / std::sqrt(x * x + y * y));
  return {static_cast<double>(x * scale), static_cast<double>(y * scale), std::clamp(v.omega, -3.0, 3.0)};
}

}  // namespace

TEST_CASE("a velocity beyond the limits keeps its direction, however long it is") {
  const RngKey key{.seed = 20, .stream = Stream::sampler};
  for (std::uint64_t i = 0; i < 20000; ++i) {
    CAPTURE(i);
    const double size = std::exp2(uniform(key, i, 0, -20.0, 1023.0));
    const double angle = uniform(key, i, 1, -4.0, 4.0);
    const Velocity v{size * std::cos(angle), size * std::sin(angle), uniform(key, i, 2, -9.0, 9.0)};
    const Velocity limited = within_limits(kLimits, v);
    const Velocity expected = oracle(v);
    REQUIRE(limited.vx == doctest::Approx(expected.vx).epsilon(1e-12));
    REQUIRE(limited.vy == doctest::Approx(expected.vy).epsilon(1e-12));
    REQUIRE(limited.omega == expected.omega);
    REQUIRE(within_limits(kLimits, limited) == limited);
  }
}

TEST_CASE("a velocity within the limits stays as it is") {
  for (const Velocity& v :
       {Velocity{}, Velocity{0.3, -0.4, 1.0}, Velocity{-1.2, 0.0, 3.0}, Velocity{0.0, 1e-300, 0.0}}) {
    CHECK(within_limits(kLimits, v) == v);
  }
}
