#include "threewe/core/time.hpp"

#include <doctest/doctest.h>

#include <random>

namespace threewe {
namespace {

TEST_CASE("seconds and nanoseconds") {
  CHECK(to_seconds(kControlPeriod) == 0.02);
  CHECK(from_seconds(0.02) == kControlPeriod);
  CHECK(from_seconds(0.0) == 0ns);
  CHECK(from_seconds(-1.5) == -1500ms);
  CHECK(from_seconds(0.6e-9) == 1ns);
  CHECK(from_seconds(-0.6e-9) == -1ns);
  CHECK(from_seconds(0.4e-9) == 0ns);
  static_assert(from_seconds(0.1) + from_seconds(0.2) == from_seconds(0.3));
}

TEST_CASE("a time survives its way through seconds while a double can tell nanoseconds apart") {
  std::mt19937_64 bits(1);
  for (int i = 0; i < 20000; ++i) {
    const Time time(static_cast<Time::rep>(bits() >> 13));  // up to 26 days
    CAPTURE(time.count());
    REQUIRE(from_seconds(to_seconds(time)) == time);
    REQUIRE(from_seconds(to_seconds(-time)) == -time);
  }
}

TEST_CASE("a million periods do not drift") {
  Time now{};
  for (int i = 0; i < 1'000'000; ++i) now += kControlPeriod;
  CHECK(now == 20'000s);
}

}  // namespace
}  // namespace threewe
