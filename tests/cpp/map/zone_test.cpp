// Polygons against what can be seen of them otherwise.
#include "threewe/map/zone.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/exact.hpp"
#include "core/rng.hpp"
#include "draw.hpp"

namespace threewe::map {
namespace {

// A star around the origin: a point is inside where it is nearer than the outline in its direction.
Zone star(std::uint64_t seed) {
  const RngKey key{.seed = seed};
  Zone zone;
  const int corners = 3 + static_cast<int>(uniform(key, 0, 0, 0.0, 9.0));
  for (int i = 0; i < corners; ++i) {
    const double radius = uniform(key, static_cast<std::uint64_t>(i) + 1, 0, 0.3, 2.0);
    zone.corners.push_back(rotate({radius, 0.0}, i * 2.0 * exact::kPi / corners));
  }
  return zone;
}

// Twice how often the outline goes round a point: the sum of the angles that its edges are seen under.
double winding(const Zone& zone, Vec2 point) {
  double sum = 0.0;
  for (std::size_t i = 0; i < zone.corners.size(); ++i) {
    const Vec2 a = zone.corners[i] - point;
    const Vec2 b = zone.corners[(i + 1) % zone.corners.size()] - point;
    sum += exact::atan2(cross(a, b), dot(a, b));
  }
  return sum / exact::kPi;
}

TEST_CASE("a point is inside where the outline goes round it") {
  for (std::uint64_t seed = 0; seed < cases(1000); ++seed) {
    CAPTURE(seed);
    const Zone zone = star(seed);
    for (std::uint64_t i = 0; i < 50; ++i) {
      const RngKey key{.seed = seed, .episode = 1};
      const Vec2 point{uniform(key, i, 0, -2.0, 2.0), uniform(key, i, 1, -2.0, 2.0)};
      REQUIRE(zone.contains(point) == (std::fabs(winding(zone, point)) > 1.0));
    }
  }
}

TEST_CASE("the distance is that to the nearest of many points on the outline") {
  for (std::uint64_t seed = 0; seed < cases(300); ++seed) {
    CAPTURE(seed);
    const Zone zone = star(seed);
    const RngKey key{.seed = seed, .episode = 2};
    const Vec2 point{uniform(key, 0, 0, -3.0, 3.0), uniform(key, 0, 1, -3.0, 3.0)};
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < zone.corners.size(); ++i) {
      const Vec2 a = zone.corners[i];
      const Vec2 b = zone.corners[(i + 1) % zone.corners.size()];
      for (int t = 0; t <= 500; ++t) nearest = std::min(nearest, distance(point, a + (t / 500.0) * (b - a)));
    }
    if (zone.contains(point)) nearest = 0.0;
    CHECK(zone.distance_to(point) <= nearest + 1e-12);
    CHECK(zone.distance_to(point) >= nearest - 0.005);
  }
}

}  // namespace
}  // namespace threewe::map
