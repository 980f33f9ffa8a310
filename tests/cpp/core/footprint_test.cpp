#include "threewe/core/footprint.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <random>

#include "core/exact.hpp"
#include "threewe/core/errors.hpp"

namespace threewe {
namespace {

// Walks along the outline in small steps.
double sampled_distance(const std::vector<Vec2>& corners, Vec2 p) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2 a = corners[i];
    const Vec2 b = corners[(i + 1) % corners.size()];
    for (int k = 0; k <= 1000; ++k) nearest = std::min(nearest, distance(p, a + (k / 1000.0) * (b - a)));
  }
  return nearest;
}

// Counts how often a ray to the right crosses the outline.
bool crosses_oddly(const std::vector<Vec2>& corners, Vec2 p) {
  bool inside = false;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2 a = corners[i];
    const Vec2 b = corners[(i + 1) % corners.size()];
    if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)) inside = !inside;
  }
  return inside;
}

// Corners on a circle around the base, at angles that leave no half circle empty.
std::vector<Vec2> random_outline(std::mt19937_64& bits) {
  std::uniform_real_distribution<double> radius(0.1, 0.5);
  std::uniform_real_distribution<double> jitter(-0.3, 0.3);
  const int n = 4 + static_cast<int>(bits() % 5);
  const double r = radius(bits);
  std::vector<Vec2> corners;
  for (int i = 0; i < n; ++i) {
    const double angle = 2 * exact::kPi * (i + jitter(bits)) / n;
    corners.push_back({r * std::cos(angle), r * std::sin(angle)});
  }
  return corners;
}

TEST_CASE("distances and insides agree with brute force") {
  std::mt19937_64 bits(1);
  std::uniform_real_distribution<double> draw(-0.8, 0.8);
  for (int i = 0; i < 200; ++i) {
    const auto corners = random_outline(bits);
    const Footprint footprint(corners);
    for (int k = 0; k < 10; ++k) {
      const Vec2 p{draw(bits), draw(bits)};
      CAPTURE(i);
      CAPTURE(k);
      const double brute = sampled_distance(corners, p);
      if (brute < 1e-3) continue;  // too near the edge for samples to tell the sides apart
      CHECK(footprint.contains(p) == crosses_oddly(corners, p));
      CHECK(std::fabs(footprint.signed_distance(p)) == doctest::Approx(brute).epsilon(1e-3));
      CHECK((footprint.signed_distance(p) < 0.0) == footprint.contains(p));
    }
    CHECK(footprint.inscribed_radius() == doctest::Approx(-footprint.signed_distance({})));
    CHECK(footprint.inscribed_radius() <= footprint.circumscribed_radius());
  }
}

TEST_CASE("a rectangle") {
  const Footprint box = Footprint::rectangle(0.25, 0.22);
  CHECK(box.corners().size() == 4);
  CHECK(box.inscribed_radius() == doctest::Approx(0.11));
  CHECK(box.circumscribed_radius() == doctest::Approx(std::hypot(0.125, 0.11)));
  CHECK(box.contains({0.125, 0.11}));
  CHECK_FALSE(box.contains({0.126, 0.0}));
  CHECK(box.signed_distance({0.225, 0.0}) == doctest::Approx(0.1));
  CHECK(box.signed_distance({0.125 + 0.03, 0.11 + 0.04}) == doctest::Approx(0.05));
  CHECK(box == Footprint(box.corners()));
}

TEST_CASE("outlines that are none") {
  CHECK_THROWS_AS(Footprint(std::vector<Vec2>{}), ConfigError);
  CHECK_THROWS_AS(Footprint(std::vector<Vec2>{{0.0, 0.0}, {1.0, 0.0}}), ConfigError);
  CHECK_THROWS_WITH_AS(Footprint({{-1, -1}, {-1, 1}, {1, 1}, {1, -1}}),
                       "footprint must be convex, its corners counter-clockwise", ConfigError);
  CHECK_THROWS_WITH_AS(Footprint({{-1, -1}, {1, -1}, {0, -0.5}, {1, 1}, {-1, 1}}),
                       "footprint must be convex, its corners counter-clockwise", ConfigError);
  CHECK_THROWS_WITH_AS(Footprint({{1, 1}, {2, 1}, {2, 2}, {1, 2}}), "footprint must contain the base (0, 0)",
                       ConfigError);
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(Footprint({{-1, -1}, {1, -1}, {kNaN, 1}, {-1, 1}}), ConfigError);
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  CHECK_THROWS_AS(Footprint({{-1, -1}, {kInfinity, -1}, {1, 1}, {-1, 1}}), ConfigError);
  // a pentagram turns left at every corner, but twice around
  std::vector<Vec2> star;
  for (int i = 0; i < 5; ++i) star.push_back({std::cos(4 * i * exact::kPi / 5), std::sin(4 * i * exact::kPi / 5)});
  CHECK_THROWS_AS(Footprint(std::vector<Vec2>(star)), ConfigError);
}

}  // namespace
}  // namespace threewe
