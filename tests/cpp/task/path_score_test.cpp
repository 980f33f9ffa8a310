// nDTW step by step is nDTW by its definition.
#include "task/path_score.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "draw.hpp"

namespace threewe::task {
namespace {

// The whole table of dynamic programming (Ilharco et al. 2019, equations 3 and 4).
double slow_ndtw(const std::vector<Vec2>& reference, const std::vector<Vec2>& query) {
  const double kInfinity = std::numeric_limits<double>::infinity();
  std::vector<std::vector<double>> d(reference.size() + 1, std::vector<double>(query.size() + 1, kInfinity));
  d[0][0] = 0.0;
  for (std::size_t i = 1; i <= reference.size(); ++i) {
    for (std::size_t j = 1; j <= query.size(); ++j) {
      d[i][j] = distance(reference[i - 1], query[j - 1]) + std::min({d[i - 1][j], d[i][j - 1], d[i - 1][j - 1]});
    }
  }
  return std::exp(-d.at(reference.size()).at(query.size()) / static_cast<double>(reference.size()));
}

std::vector<Vec2> random_corners(Draw& draw) {
  Vec2 corner = draw.point(-2.0, 2.0);
  std::vector<Vec2> corners = {corner};
  for (int i = draw.whole(1, 5); i > 0; --i) corners.push_back(corner = corner + draw.point(-2.0, 2.0));
  return corners;
}

TEST_CASE("points along a path are evenly spaced, its ends included") {
  for (std::uint64_t seed = 0; seed < cases(300); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    const std::vector<Vec2> corners = random_corners(draw);
    const std::vector<Vec2> points = points_along(corners, 0.25);
    double length = 0.0;
    for (std::size_t i = 1; i < corners.size(); ++i) length += distance(corners[i - 1], corners[i]);
    CHECK(points.front() == corners.front());
    CHECK(points.back() == corners.back());
    CHECK(static_cast<double>(points.size()) == doctest::Approx(std::ceil(length / 0.25 - 1e-9) + 1.0));
    for (std::size_t i = 1; i < points.size(); ++i) CHECK(distance(points[i - 1], points[i]) <= 0.25 + 1e-9);
  }
}

TEST_CASE("the score of a drive is that of its points, 0.25 m apart") {
  for (std::uint64_t seed = 0; seed < cases(300); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    const std::vector<Vec2> reference = points_along(random_corners(draw), kPathSpacing);
    REQUIRE(reference.size() <= kMostPathPoints);
    Vec2 robot = reference.at(0) + draw.point(-0.2, 0.2);
    PathScore score = begin_score(reference, robot);
    std::vector<Vec2> track = {robot};
    for (int step = draw.whole(0, 400); step > 0; --step) {
      const bool waits = draw.whole(0, 3) == 0;
      if (!waits) robot = robot + draw.point(-0.1, 0.12) + (step % 50 == 0 ? draw.point(-1.0, 1.0) : Vec2{});
      advance(score, reference, robot);
      track.push_back(robot);
      if (step % 97 != 1) continue;
      CHECK(ndtw(score, reference) == doctest::Approx(slow_ndtw(reference, points_along(track, kPathSpacing))));
    }
  }
}

TEST_CASE("keeping to the path scores 1, whatever the control rate; straying scores less") {
  Draw draw(1);
  const std::vector<Vec2> corners = {{0.0, 0.0}, {3.0, 0.0}, {3.0, 4.0}};
  const std::vector<Vec2> reference = points_along(corners, kPathSpacing);
  const auto drive = [&](double step, Vec2 aside, int waits) {
    PathScore score = begin_score(reference, corners.front());
    for (const Vec2 p : points_along(corners, step)) {
      for (int i = 0; i <= waits; ++i) advance(score, reference, p + aside);
    }
    return ndtw(score, reference);
  };
  CHECK(drive(0.25, {}, 0) > 0.999);
  CHECK(drive(0.25, {}, 10) == drive(0.25, {}, 0));
  CHECK(drive(0.01, {}, 0) > 0.98);
  CHECK(drive(0.05, {0.5, 0.5}, 0) < 0.7);
  CHECK(drive(0.05, {0.5, 0.5}, 0) == doctest::Approx(drive(0.05, {0.5, 0.5}, 5)));
}

}  // namespace
}  // namespace threewe::task
