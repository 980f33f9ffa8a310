// Walls nearer than a lidar can measure.
#include "map/blind_surface.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/exact.hpp"
#include "core/rng.hpp"
#include "draw.hpp"

namespace threewe::map {
namespace {

constexpr double kRangeMin = 0.16;  // [m]
constexpr int kBeams = 230;

// What such a lidar hits of an endless wall, `away` [m] from it in the direction of `normal` [rad].
std::vector<Vec2> scan_of_wall(Vec2 lidar, double away, double normal, const RngKey& key, double sigma) {
  std::vector<Vec2> hits;
  for (int i = 0; i < kBeams; ++i) {
    const double bearing = 2.0 * exact::kPi * i / kBeams;
    const double along = std::cos(bearing - normal);
    if (along <= 0.05) continue;
    const double range = away / along + sigma * uniform(key, static_cast<std::uint64_t>(i), 0, -1.7, 1.7);
    if (range >= kRangeMin) hits.push_back(lidar + rotate({range, 0.0}, bearing));
  }
  return hits;
}

TEST_CASE("a wall goes on where it is too near to be seen") {
  for (std::uint64_t seed = 0; seed < cases(300); ++seed) {
    CAPTURE(seed);
    const RngKey key{.seed = seed};
    const Vec2 lidar{uniform(key, 1000, 0, -3.0, 3.0), uniform(key, 1000, 1, -3.0, 3.0)};
    const double normal = uniform(key, 1001, 0, -exact::kPi, exact::kPi);
    const double away = uniform(key, 1002, 0, 0.06, 0.14);
    const double sigma = 0.01;
    const std::vector<Vec2> found = blind_surface(scan_of_wall(lidar, away, normal, key, sigma), lidar, kRangeMin);
    REQUIRE(found.size() >= 4);
    double nearest = 1.0;
    for (const Vec2 p : found) {
      CHECK(distance(p, lidar) < kRangeMin);
      CHECK(std::fabs(rotate(p - lidar, -normal).x - away) < 4.0 * sigma);
      nearest = std::min(nearest, distance(p, lidar));
    }
    CHECK(nearest < away + 3.0 * sigma);
  }
}

TEST_CASE("what a lidar would have seen is not made up") {
  CHECK(blind_surface({}, {}, kRangeMin).empty());
  // legs to the left and to the right, and a way between them: half a turn apart
  CHECK(blind_surface(std::vector<Vec2>{{0.0, 0.18}, {0.0, -0.18}}, {}, kRangeMin).empty());
  // two legs ahead, the line between which lies beyond the blind disc
  CHECK(blind_surface(std::vector<Vec2>{{0.19, 0.08}, {0.19, -0.08}}, {}, kRangeMin).empty());
  // two legs, between which the lidar sees a wall
  CHECK(blind_surface(std::vector<Vec2>{{0.1, 0.14}, {0.1, -0.14}, {2.0, 0.0}}, {}, kRangeMin).empty());
  // a lidar that sees all that is outside of its robot
  CHECK(blind_surface(scan_of_wall({}, 0.12, 0.0, {.seed = 1}, 0.0), {}, 0.02).empty());
}

}  // namespace
}  // namespace threewe::map
