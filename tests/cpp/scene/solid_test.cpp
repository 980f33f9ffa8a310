// Distances and overlaps of solids agree with points sampled densely on their outlines.
#include "threewe/scene/solid.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <limits>

#include "core/exact.hpp"
#include "scene/obstacles.hpp"
#include "scene/random_solids.hpp"
#include "threewe/core/footprint.hpp"

namespace threewe::scene {
namespace {

constexpr double kSpacing = 0.002;  // [m] of sampled points

std::vector<Vec2> placed(const Footprint& footprint, const Pose2D& pose) {
  std::vector<Vec2> outline;
  for (const Vec2 corner : footprint.corners()) outline.push_back(pose * corner);
  return outline;
}

TEST_CASE("a box at a quarter turn has sides along the axes, exactly") {
  const Solid box = make_box({1.0, 2.0, 0.5 * exact::kPi}, 4.0, 2.0);
  CHECK(box.corners == std::array<Vec2, 4>{Vec2{2.0, 0.0}, Vec2{2.0, 4.0}, Vec2{0.0, 4.0}, Vec2{0.0, 0.0}});
}

TEST_CASE("the distance from a point is that to the nearest sampled point of the outline") {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    CAPTURE(seed);
    Dice dice(seed);
    const Solid solid = random_solid(dice, 1.0);
    const Vec2 point{dice.in(-2.0, 2.0), dice.in(-2.0, 2.0)};
    double sampled = std::numeric_limits<double>::infinity();
    for (const Vec2 p : outline_points(solid, kSpacing)) sampled = std::min(sampled, distance(p, point));
    if (holds(solid, point)) sampled = 0.0;
    const double exact_distance = distance_to(solid, point);
    CHECK(exact_distance <= sampled + 1e-12);
    CHECK(sampled <= exact_distance + kSpacing);
  }
}

TEST_CASE("a solid and a polygon overlap where a sampled point of one lies in the other") {
  int overlapping = 0;
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    CAPTURE(seed);
    Dice dice(seed);
    const Solid solid = random_solid(dice, 0.6);
    const Footprint robot = Footprint::rectangle(dice.in(0.1, 0.6), dice.in(0.1, 0.6));
    const Pose2D pose{dice.in(-0.6, 0.6), dice.in(-0.6, 0.6), dice.in(-3.0, 3.0)};
    const std::vector<Vec2> polygon = placed(robot, pose);

    bool touching = holds(solid, pose.position()) || robot.contains(inverse(pose) * solid.center);
    double apart = std::numeric_limits<double>::infinity();
    for (const Vec2 p : outline_points(polygon, kSpacing)) {
      touching = touching || holds(solid, p);
      apart = std::min(apart, distance_to(solid, p));
    }
    for (const Vec2 p : outline_points(solid, kSpacing)) touching = touching || robot.contains(inverse(pose) * p);

    // samples can miss an overlap that is thinner than their spacing
    if (touching || !overlaps(solid, polygon, kSpacing)) CHECK(overlaps(solid, polygon) == touching);
    const double exact_distance = distance_to(solid, polygon);
    CHECK(exact_distance <= apart + 1e-12);
    if (!touching) CHECK(apart <= exact_distance + kSpacing);
    CHECK((exact_distance == 0.0) == overlaps(solid, polygon));
    overlapping += touching ? 1 : 0;
  }
  CHECK(overlapping > 50);
  CHECK(overlapping < 450);
}

TEST_CASE("whether two solids overlap does not depend on their order, nor touching on being told of as overlap") {
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    CAPTURE(seed);
    Dice dice(seed);
    const Solid a = random_solid(dice, 0.5);
    const Solid b = random_solid(dice, 0.5);
    CHECK(overlaps(a, b) == overlaps(b, a));
    CHECK((!overlaps(a, b, 0.05) || overlaps(a, b)));
  }
  CHECK_FALSE(overlaps(make_box({0, 0, 0}, 2, 2), make_box({2, 0, 0}, 2, 2)));
  CHECK_FALSE(overlaps(make_disc({0, 0}, 1), make_disc({2, 0}, 1)));
  CHECK(overlaps(make_box({0, 0, 0}, 2, 2), make_box({1.99, 0, 0}, 2, 2)));
}

TEST_CASE("obstacles find what a search through all of them finds") {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    CAPTURE(seed);
    Dice dice(seed);
    const std::vector<Solid> solids = random_solids(dice, 30, 4.0);
    const Obstacles obstacles(solids);
    for (int i = 0; i < 50; ++i) {
      const double size = dice.in(0.1, 1.4);  // some reach further than the index
      const Footprint robot = Footprint::rectangle(size, dice.in(0.1, 0.4));
      const Pose2D pose{dice.in(-7.0, 7.0), dice.in(-7.0, 7.0), dice.in(-3.0, 3.0)};
      const std::vector<Vec2> outline = placed(robot, pose);
      double from_point = std::numeric_limits<double>::infinity();
      double from_robot = from_point;
      for (const Solid& s : solids) {
        from_point = std::min(from_point, distance_to(s, pose.position()));
        from_robot = std::min(from_robot, distance_to(s, outline));
      }
      CHECK(obstacles.clearance(pose.position()) == from_point);
      CHECK(obstacles.clearance(robot, pose) == doctest::Approx(from_robot).epsilon(1e-12));
      CHECK(obstacles.collides(robot, pose) == (from_robot == 0.0));
    }
  }
  CHECK_FALSE(Obstacles({}).collides(Footprint::rectangle(1, 1), {}));
  CHECK(Obstacles({}).clearance(Vec2{}) == std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace threewe::scene
