#include "map/scan_hits.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "core/exact.hpp"
#include "draw.hpp"

namespace threewe::map {
namespace {

struct Segment {
  Vec2 a;
  Vec2 b;
};

double range_to(const Segment& segment, Vec2 from, Vec2 direction) {
  const Vec2 along = segment.b - segment.a;
  const double across = cross(direction, along);
  if (std::fabs(across) < 1e-12) return 1e9;
  const double range = cross(segment.a - from, along) / across;
  const double share = cross(segment.a - from, direction) / across;
  return range > 0.0 && share >= 0.0 && share <= 1.0 ? range : 1e9;
}

// What a lidar of 360 beams and 1 cm of scatter hits within a metre.
std::vector<Vec2> scan(const std::vector<Segment>& segments, Vec2 lidar, std::mt19937_64& bits) {
  std::normal_distribution<double> scatter(0.0, 0.01);
  std::vector<Vec2> hits;
  for (int i = 0; i < 360; ++i) {
    const double angle = 2.0 * exact::kPi * (i + 0.3) / 360;
    const Vec2 direction{std::cos(angle), std::sin(angle)};
    double range = 1e9;
    for (const Segment& s : segments) range = std::min(range, range_to(s, lidar, direction));
    if (range < 1.0) hits.push_back(lidar + (range + scatter(bits)) * direction);
  }
  return hits;
}

// Two jambs of a doorway along x, `half` to either side.
std::vector<Segment> doorway(double half, double thickness) {
  std::vector<Segment> segments;
  for (const double side : {1.0, -1.0}) {
    segments.push_back({{0.0, side * half}, {0.0, side * 2.0}});
    segments.push_back({{thickness, side * half}, {thickness, side * 2.0}});
    segments.push_back({{0.0, side * half}, {thickness, side * half}});
  }
  return segments;
}

// How far [m] hits on the jambs reach into the doorway.
double intrusion(const std::vector<Vec2>& hits, double half, double thickness) {
  double least = half;
  for (const Vec2 p : hits) {
    if (p.x > -0.02 && p.x < thickness + 0.02) least = std::min(least, std::fabs(p.y));
  }
  return half - least;
}

TEST_CASE("a flat wall becomes flat, whatever its direction") {
  std::mt19937_64 bits(1);
  std::normal_distribution<double> scatter(0.0, 0.01);
  double before = 0.0;
  double after = 0.0;
  for (std::uint64_t seed = 0; seed < cases(200); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    const Pose2D wall = draw.pose(-2.0, 2.0);
    const Vec2 lidar = wall * Vec2{draw(-0.3, 0.3), -draw(0.15, 0.6)};
    std::vector<Vec2> hits;
    for (int i = 0; i < 80; ++i) {
      const Vec2 ray = wall * Vec2{-0.4 + 0.01 * i, 0.0} - lidar;
      hits.push_back(lidar + (1.0 + scatter(bits) / norm(ray)) * ray);
    }
    const std::vector<Vec2> moved = smoothed(hits, lidar);
    REQUIRE(moved.size() == hits.size());
    for (std::size_t i = 10; i + 10 < hits.size(); ++i) {
      before += std::pow((inverse(wall) * hits[i]).y, 2);
      after += std::pow((inverse(wall) * moved[i]).y, 2);
    }
  }
  MESSAGE("scatter shrinks to " << std::sqrt(after / before) << " of what it was");
  CHECK(after < 0.36 * before);
}

TEST_CASE("a doorway stays open from before it to behind it, corners and all") {
  std::mt19937_64 bits(2);
  for (const double thickness : {0.06, 0.12, 0.25}) {
    double raw = 0.0;
    double left = 0.0;
    int count = 0;
    for (int step = 0; step < 12; ++step) {
      const double x = -0.1 + (thickness + 0.2) * step / 12;
      for (std::uint64_t i = 0; i < cases(50); ++i, ++count) {
        const std::vector<Vec2> hits = scan(doorway(0.135, thickness), {x, 0.004}, bits);
        raw += intrusion(hits, 0.135, thickness);
        left += intrusion(smoothed(hits, {x, 0.004}), 0.135, thickness);
      }
    }
    CAPTURE(thickness);
    CHECK(raw / count > 0.018);
    CHECK(left / count < 0.7 * raw / count);
  }
}

TEST_CASE("what stands alone stays where it is") {
  const std::vector<Vec2> lone = {{1.0, 0.0}, {1.0, 0.2}, {0.8, -0.3}, {0.81, -0.3}};
  CHECK(smoothed(lone, {}) == lone);
  CHECK(smoothed({}, {}).empty());
}

}  // namespace
}  // namespace threewe::map
