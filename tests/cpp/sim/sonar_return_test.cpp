// SonarReturns against fans of dense rays.
#include "sim/sonar_return.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "core/rng.hpp"
#include "draw.hpp"
#include "threewe/scene/solid.hpp"

using namespace threewe;
using namespace threewe::sim;

namespace {

constexpr double kDegree = M_PI / 180.0;
constexpr double kFar = 4.0;

SonarCone cone_at(const Pose2D& sensor) { return {sensor, 15.0 * kDegree, 25.0 * kDegree, kFar}; }

SonarReturn hear(const SonarCone& cone, const scene::Slice& slice, const MovingShapes& moving = {}) {
  return nearest_sonar_return(cone, ShapeIndex(slice, cone.range_max, 1.0), moving);
}

scene::Slice slice_of(const std::vector<scene::Solid>& solids) { return scene::outlines(solids); }

// What one ray meets first: how far away, and how far off the surface's normal it comes.
struct Hit {
  double range = std::numeric_limits<double>::infinity();
  double incidence = 0.0;
};

// Each shape by itself, by the scene's own ray; then its normal at that point.
Hit slow_ray(const scene::Slice& slice, Vec2 origin, double angle) {
  const Vec2 direction{std::cos(angle), std::sin(angle)};
  Hit hit;
  const auto intersect = [&](const scene::Slice& alone, auto normal_at) {
    const double range = scene::cast_ray(alone, origin, angle, 1e9);
    if (range >= hit.range || range >= 1e9) return;
    const Vec2 normal = normal_at(origin + range * direction);
    hit = {range, std::acos(std::min(-dot(normal, direction) / norm(normal), 1.0))};
  };
  for (const scene::Segment& segment : slice.segments) {
    const Vec2 along = segment.b - segment.a;
    intersect({{segment}, {}}, [&](Vec2) { return Vec2{along.y, -along.x}; });
  }
  for (const scene::Circle& circle : slice.circles) {
    intersect({{}, {circle}}, [&](Vec2 point) { return point - circle.center; });
  }
  return hit;
}

double slow_echo(const SonarCone& cone, const scene::Slice& slice, int rays) {
  double nearest = cone.range_max;
  for (int i = 0; i <= rays; ++i) {
    const double angle = cone.sensor.theta + cone.field_of_view * (static_cast<double>(i) / rays - 0.5);
    const Hit hit = slow_ray(slice, cone.sensor.position(), angle);
    if (hit.incidence <= cone.max_incidence) nearest = std::min(nearest, hit.range);
  }
  return nearest;
}

// Whether a ray where the echo is said to come from, or right beside it, tells the same.
bool confirmed(const SonarCone& cone, const scene::Slice& slice, const SonarReturn& echo) {
  for (const double beside : {0.0, 3e-9, -3e-9, 1e-7, -1e-7}) {
    const double angle = std::atan(echo.bearing) + beside;
    const Hit hit = slow_ray(slice, cone.sensor.position(), cone.sensor.theta + angle);
    const bool inside = std::abs(angle) <= 0.5 * cone.field_of_view + 1e-6;
    if (inside && std::abs(hit.range - echo.range) < 1e-5 && hit.incidence <= cone.max_incidence + 1e-6) return true;
  }
  return false;
}

// Boxes and discs, some of which overlap, some of which are tiny; never one over the sensor.
scene::Slice random_slice(const RngKey& key, std::uint64_t round) {
  std::vector<scene::Solid> solids;
  const auto count = static_cast<std::uint32_t>(uniform(key, round, 0, 1.0, 14.0));
  for (std::uint32_t i = 1; i <= count; ++i) {
    const auto draw = [&](std::uint32_t lane, double low, double high) {
      return uniform(key, round, 8 * i + lane, low, high);
    };
    const Vec2 middle{draw(0, -4.0, 4.0), draw(1, -4.0, 4.0)};
    const double size = draw(2, 0.0, 1.0);
    const scene::Solid solid = draw(3, 0.0, 1.0) < 0.6
                                   ? scene::make_box({middle.x, middle.y, draw(4, -M_PI, M_PI)},
                                                     0.02 + 3.0 * size * size, 0.02 + draw(5, 0.0, 0.5))
                                   : scene::make_disc(middle, 0.01 + 0.5 * size);
    solids.push_back(solid);
  }
  return slice_of(solids);
}

}  // namespace

TEST_CASE("a wall ahead is heard at its nearest point, and one aslant not at all") {
  const scene::Slice wall = slice_of({scene::make_box({2.05, 0.0, 0.0}, 0.1, 10.0)});
  CHECK(hear(cone_at({}), wall).range == doctest::Approx(2.0));
  // 20 degrees aslant: the foot of the perpendicular is outside of the cone, whose edge meets the wall at 12.5 degrees
  CHECK(hear(cone_at({0.0, 0.0, 20.0 * kDegree}), wall).range == doctest::Approx(2.0 / std::cos(12.5 * kDegree)));
  // of a wall 30 degrees aslant the cone's inner edge still hears something; of one at 33 degrees, nothing
  CHECK(hear(cone_at({0.0, 0.0, 30.0 * kDegree}), wall).range == doctest::Approx(2.0 / std::cos(22.5 * kDegree)));
  CHECK(hear(cone_at({0.0, 0.0, 33.0 * kDegree}), wall).range == kFar);
  CHECK(hear(cone_at({-3.0, 0.0, 0.0}), wall).range == kFar);
  CHECK(hear(cone_at({}), {}).range == kFar);
}

TEST_CASE("a leg in front of a wall is heard first, and only while it is in the cone") {
  const std::vector<scene::Solid> solids{scene::make_box({2.05, 0.0, 0.0}, 0.1, 10.0),
                                         scene::make_disc({1.0, 0.1}, 0.02)};
  const scene::Slice slice = slice_of(solids);
  CHECK(hear(cone_at({}), slice).range == doctest::Approx(std::hypot(1.0, 0.1) - 0.02));
  CHECK(hear(cone_at({0.0, 0.0, -0.1}), slice).range == doctest::Approx(2.0));
}

TEST_CASE("what glances off a surface still cannot reach what stands behind it") {
  // a slanted board across the whole cone, and a wall behind it
  const std::vector<scene::Solid> solids{scene::make_box({1.0, 0.0, M_PI / 4}, 2.0, 0.02),
                                         scene::make_box({3.05, 0.0, 0.0}, 0.1, 10.0)};
  CHECK(hear(cone_at({}), slice_of(solids)).range == kFar);
  CHECK(hear(cone_at({}), slice_of({solids[1]})).range == doctest::Approx(3.0));
}

TEST_CASE("what crosses the edge of the cone hides what stands behind it there, too") {
  // the nearest point of a wall that faces 20 degrees to the right is at the right edge; there stands a silent board
  const auto towards = [](double degrees, double range) {
    return Pose2D{range * std::cos(degrees * kDegree), range * std::sin(degrees * kDegree), degrees * kDegree};
  };
  Pose2D board = towards(-7.5, 1.0);
  board.theta += 45.0 * kDegree;
  const std::vector<scene::Solid> solids{scene::make_box(towards(-20.0, 3.05), 0.1, 10.0),
                                         scene::make_box(board, 0.1, 0.01)};
  const SonarCone cone = cone_at({});
  CHECK(hear(cone, slice_of({solids[0]})).range == doctest::Approx(3.0 / std::cos(12.5 * kDegree)));
  CHECK(hear(cone, slice_of(solids)).range == doctest::Approx(slow_echo(cone, slice_of(solids), 20000)));
  CHECK(hear(cone, slice_of(solids)).range > 3.1);
}

TEST_CASE("the wall behind is heard through the gap that is left") {
  // a slanted board over one half of the cone, up to its axis and a little more
  const std::vector<scene::Solid> solids{scene::make_box({1.0, 0.5, M_PI / 4}, 1.4, 0.001),
                                         scene::make_box({3.05, 0.0, 0.0}, 0.1, 10.0)};
  const SonarReturn echo = hear(cone_at({}), slice_of(solids));
  CHECK(echo.range == doctest::Approx(3.0).epsilon(0.01));
  CHECK(confirmed(cone_at({}), slice_of(solids), echo));
}

TEST_CASE("moving shapes are heard as those that stand") {
  const std::vector<scene::Solid> all{scene::make_box({1.0, 0.2, 0.3}, 0.3, 0.3), scene::make_disc({1.5, -0.1}, 0.2),
                                      scene::make_box({2.05, 0.0, 0.0}, 0.1, 10.0)};
  const scene::Slice standing = slice_of({all[2]});
  const scene::Slice moving = slice_of({all[0], all[1]});
  for (int i = -100; i <= 100; ++i) {
    const SonarCone cone = cone_at({0.0, 0.0, 0.01 * i});
    CHECK(hear(cone, standing, {moving.segments, moving.circles}).range == hear(cone, slice_of(all)).range);
  }
}

TEST_CASE("thousands of random echoes against fans of dense rays") {
  const RngKey key{.seed = 21, .stream = Stream::scene};
  std::uint64_t heard = 0;
  std::uint64_t deaf = 0;
  for (std::uint64_t round = 0; round < cases(6000); ++round) {
    CAPTURE(round);
    const scene::Slice slice = random_slice(key, round);
    SonarCone cone = cone_at({uniform(key, round, 1000, -1.0, 1.0), uniform(key, round, 1001, -1.0, 1.0),
                              uniform(key, round, 1002, -M_PI, M_PI)});
    if (round % 3 == 1) cone.field_of_view = uniform(key, round, 1003, 0.01, 2.0);
    if (round % 3 == 2) cone.max_incidence = uniform(key, round, 1004, 0.05, 1.5);
    const SonarReturn echo = hear(cone, slice);
    // nothing nearer is missed ...
    CHECK(echo.range <= slow_echo(cone, slice, 400) + 1e-6);
    // ... and what is heard is there
    if (echo.range < cone.range_max) CHECK(confirmed(cone, slice, echo));
    (echo.range < cone.range_max ? heard : deaf) += 1;
  }
  CHECK(heard > cases(1500));
  CHECK(deaf > cases(500));
}
