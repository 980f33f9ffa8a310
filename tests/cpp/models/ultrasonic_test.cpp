#include "models/ultrasonic.hpp"

#include <doctest/doctest.h>

#include <cmath>

using namespace threewe;
using namespace threewe::models;

namespace {

UltrasonicSpec hc_sr04() { return *load_profile("3we_standard_v2").ultrasonics; }

}  // namespace

TEST_CASE("ranges scatter around the echo as much as the data sheet says") {
  const UltrasonicSpec spec = hc_sr04();
  const RngKey key{.seed = 3, .stream = Stream::ultrasonic};
  constexpr std::uint64_t kPings = 20'000;
  double sum = 0.0;
  double squares = 0.0;
  for (std::uint64_t ping = 0; ping < kPings; ++ping) {
    const double off = measure_range(spec, key, ping, 1.5) - 1.5;
    sum += off;
    squares += off * off;
  }
  CHECK(std::fabs(sum / kPings) < 0.03 * spec.sigma);
  CHECK(std::sqrt(squares / kPings) == doctest::Approx(spec.sigma).epsilon(0.02));
}

TEST_CASE("too near is invalid, too far is no echo, and nothing lies in between") {
  const UltrasonicSpec spec = hc_sr04();
  const RngKey key{.seed = 4, .stream = Stream::ultrasonic};
  CHECK(measure_range(spec, key, 0, spec.range_max) == spec.range_max);
  CHECK(measure_range(spec, key, 0, 0.001) == 0.0);
  for (std::uint64_t ping = 0; ping < 2000; ++ping) {
    for (const double echo : {spec.range_min, spec.range_max - 0.001}) {
      const double range = measure_range(spec, key, ping, echo);
      CHECK((range == 0.0 || (range >= spec.range_min && range <= spec.range_max)));
    }
  }
}

TEST_CASE("noise depends on the sensor and the ping, and an ideal sensor has none") {
  UltrasonicSpec spec = hc_sr04();
  const RngKey key{.seed = 5, .stream = Stream::ultrasonic};
  RngKey other = key;
  other.sensor = 1;
  CHECK(measure_range(spec, key, 7, 1.0) == measure_range(spec, key, 7, 1.0));
  CHECK(measure_range(spec, key, 7, 1.0) != measure_range(spec, key, 8, 1.0));
  CHECK(measure_range(spec, key, 7, 1.0) != measure_range(spec, other, 7, 1.0));
  spec.sigma = 0.0;
  CHECK(measure_range(spec, key, 7, 1.0) == 1.0);
}
