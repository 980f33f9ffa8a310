#include "perception/sonar_returns.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "core/rng.hpp"

using namespace threewe;
using namespace threewe::perception;

namespace {

RangeData echo(double range) { return {15.0 * M_PI / 180.0, 0.02, 4.0, range}; }

}  // namespace

TEST_CASE("wherever in the cone an echo came from, a point is near, and none is nearer to the sensor") {
  const RngKey key{.seed = 1, .stream = Stream::sampler};
  for (std::uint64_t i = 0; i < 2000; ++i) {
    CAPTURE(i);
    const double range = uniform(key, i, 0, 0.02, 3.99);
    const double angle = uniform(key, i, 1, -7.5, 7.5) * M_PI / 180.0;
    const Vec2 surface{range * std::cos(angle), range * std::sin(angle)};
    const std::vector<Vec2> arc = sonar_arc(echo(range));
    CHECK(std::ranges::any_of(arc, [&](Vec2 p) { return distance(p, surface) <= 0.0101; }));
    CHECK(std::ranges::all_of(arc, [&](Vec2 p) { return std::fabs(norm(p) - range) < 1e-12; }));
  }
}

TEST_CASE("no echo is no obstacle; one too near to be measured is right at the sensor") {
  CHECK(sonar_arc(echo(4.0)).empty());
  REQUIRE_FALSE(sonar_arc(echo(0.0)).empty());
  CHECK(norm(sonar_arc(echo(0.0)).front()) == doctest::Approx(0.02));
}

TEST_CASE("a sensor's newest echo takes the place of its last, and of no other's") {
  SonarReturns sonar_returns;
  CHECK(sonar_returns.points_in_odom().empty());
  sonar_returns.update(1, echo(1.0), {2.0, 0.0, 0.0});
  const std::size_t one = sonar_returns.points_in_odom().size();
  CHECK(sonar_returns.points_in_odom().front().x == doctest::Approx(2.0 + std::cos(7.5 * M_PI / 180.0)));
  sonar_returns.update(3, echo(1.0), {0.0, 0.0, 1.0});
  CHECK(sonar_returns.points_in_odom().size() == 2 * one);
  sonar_returns.update(1, echo(4.0), {});
  CHECK(sonar_returns.points_in_odom().size() == one);
}
