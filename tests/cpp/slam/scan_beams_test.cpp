// Beams made of scans: where the points of a driver's beams lie.
#include "slam/scan_beams.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "draw.hpp"

namespace threewe::slam {
namespace {

constexpr int kBeams = 360;
constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kIncrement = kTurn / kBeams;

// A scan of a wall at y = `away`, by a driver that keeps the nearest of the points in each beam; `phase` [point] of the
// first.
LaserScan scan_of_wall(int points, double away, double phase) {
  LaserScan scan;
  scan.angle_min = -std::numbers::pi;
  scan.angle_increment = kIncrement;
  scan.range_min = 0.02;
  scan.range_max = 12.0;
  scan.ranges.assign(kBeams, std::numeric_limits<float>::infinity());
  for (int k = 0; k < points; ++k) {
    const double angle = (k + phase) / points * kTurn;  // from the edge of the first beam
    const double ray = scan.angle_min - 0.5 * scan.angle_increment + angle;
    const double range = std::sin(ray) > 0.01 ? std::min(away / std::sin(ray), 12.0) : 12.0;
    float& nearest = scan.ranges[static_cast<std::size_t>(angle / scan.angle_increment)];
    nearest = std::min(nearest, static_cast<float>(range));
  }
  return scan;
}

// [m] by which the hits at 35 to 55 degrees to the wall lie before it, on average over all phases.
double bend(int points, double away, double offset) {
  double sum = 0.0;
  int count = 0;
  Draw draw(7);
  for (int turn = 0; turn < 400; ++turn) {
    const LaserScan scan = scan_of_wall(points, away, draw(0.0, 1.0));
    for (const map::Beam& beam : beams_of(scan, 12.0, [](std::size_t) { return Pose2D{}; }, {}, offset)) {
      const double steep = std::asin(beam.direction.y) * 180.0 / std::numbers::pi;
      if (!beam.hit || steep < 35.0 || steep > 55.0) continue;
      sum += away - beam.range * beam.direction.y;
      ++count;
    }
  }
  return sum / count;
}

}  // namespace

TEST_CASE("a wall is not bent by a driver that keeps the nearest of the points in a beam") {
  CHECK(point_offset(0, kIncrement) == 0.0);
  CHECK(point_offset(360, kIncrement) == 0.0);
  CHECK(point_offset(450, kIncrement) == doctest::Approx(0.1));
  CHECK(point_offset(720, -kIncrement) == doctest::Approx(0.25));
  for (const int points : {450, 720}) {
    CAPTURE(points);
    const double seen = bend(points, 7.0, 0.0);
    CHECK(seen > 0.01);
    CHECK(std::fabs(bend(points, 7.0, point_offset(points, kIncrement))) < 0.1 * seen);
  }
  CHECK(std::fabs(bend(360, 7.0, 0.0)) < 0.002);
}

}  // namespace threewe::slam
