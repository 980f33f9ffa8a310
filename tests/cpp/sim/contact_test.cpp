#include "sim/contact.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "core/rng.hpp"
#include "draw.hpp"
#include "sim/bodies.hpp"

using namespace threewe;
using namespace threewe::sim;

namespace {

constexpr double kSeconds = 0.01;

RigidBody robot() { return box_body(); }

ShapeIndex index(const std::vector<scene::Solid>& solids, const RigidBody& body = robot()) {
  return {scene::outlines(solids), contact_reach(body.footprint, 2.0, 6.0, kSeconds)};
}

double energy(const RigidBody& body, const Velocity& v) {
  return body.mass * (v.vx * v.vx + v.vy * v.vy) + body.inertia * v.omega * v.omega;
}

// Drives into the solids with the same velocity at every step, as wheels with unlimited grip would.
Motion push(const std::vector<scene::Solid>& solids, Pose2D pose, const Velocity& velocity, int steps) {
  const RigidBody body = robot();
  const ShapeIndex shapes = index(solids);
  Motion motion;
  for (int i = 0; i < steps; ++i) {
    motion = move(body, shapes, {}, pose, velocity, i == 0 ? velocity : motion.velocity, kSeconds);
    pose = motion.pose;
  }
  return motion;
}

// A wall whose near face is the line x = 1.
std::vector<scene::Solid> wall() { return {scene::make_box({1.05, 0.0, 0.0}, 0.1, 10.0)}; }

}  // namespace

TEST_CASE("in the open a body follows its arc") {
  const Velocity velocity{1.0, -0.5, 2.0};
  const Motion motion = move(robot(), index(wall()), {}, {-3.0, 0.0, 0.5}, velocity, velocity, kSeconds);
  CHECK(motion.pose == integrate({-3.0, 0.0, 0.5}, velocity, kSeconds));
  CHECK(motion.velocity == velocity);
  CHECK_FALSE(motion.touching);
}

TEST_CASE("a body that drives straight at a wall stops at it, and its speed of impact is told") {
  const RigidBody body = robot();
  const ShapeIndex shapes = index(wall());
  Pose2D pose{0.8, 0.3, 0.0};
  const Velocity velocity{1.2, 0.0, 0.0};
  Velocity carried = velocity;
  double impact = 0.0;
  for (int i = 0; i < 50; ++i) {
    const Motion motion = move(body, shapes, {}, pose, velocity, carried, kSeconds);
    pose = motion.pose;
    carried = motion.velocity;
    impact = std::max(impact, motion.approach_speed);
    CHECK_FALSE(inside(wall(), body, pose));
  }
  CHECK(impact == doctest::Approx(1.2));
  CHECK(pose.x == doctest::Approx(1.0 - 0.125).epsilon(0.001));
  CHECK(gap(wall(), body, pose) < 1e-3);
  CHECK(pose.y == doctest::Approx(0.3));
  CHECK(std::fabs(carried.vx) < 1e-6);
}

TEST_CASE("leaning against a wall is no collision") {
  const RigidBody body = robot();
  const ShapeIndex shapes = index(wall());
  // it stands at the wall; its wheels push it afresh at every step, but it carries no speed into the wall
  Pose2D pose{1.0 - 0.125 - 2e-4, 0.0, 0.0};
  Velocity carried;
  for (int i = 0; i < 100; ++i) {
    const Motion motion = move(body, shapes, {}, pose, {0.07, 0.0, 0.0}, carried, kSeconds);
    CHECK(motion.approach_speed < 1e-6);
    CHECK(motion.touching);
    pose = motion.pose;
    carried = motion.velocity;
  }
}

TEST_CASE("a body slides along a wall at the speed that it has along it") {
  const Motion motion = push(wall(), {0.87, 0.0, 0.0}, {0.5, 0.5, 0.0}, 200);
  CHECK(motion.touching);
  CHECK(motion.velocity.vx == doctest::Approx(0.0).scale(1.0).epsilon(1e-6));
  CHECK(motion.velocity.vy == doctest::Approx(0.5).epsilon(0.001));
  CHECK(motion.pose.y == doctest::Approx(0.5 * 2.0).epsilon(0.02));
}

TEST_CASE("a corner that meets a wall turns the body") {
  // turned to the left, it meets the wall with its front right corner, which pushes it round to the left
  const Motion first = push(wall(), {0.83, 0.0, 0.3}, {0.5, 0.0, 0.0}, 8);
  CHECK(first.velocity.omega != 0.0);
  CHECK_FALSE(inside(wall(), robot(), first.pose));
}

TEST_CASE("no wall is too thin to stop a body") {
  for (const double thickness : {0.1, 0.01, 0.001, 1e-4}) {
    CAPTURE(thickness);
    const std::vector<scene::Solid> wall{scene::make_box({1.0 + 0.5 * thickness, 0.0, 0.0}, thickness, 40.0)};
    for (const double heading : {0.0, 0.3, 0.7, 1.5, 3.0}) {
      CAPTURE(heading);
      const Vec2 velocity = rotate({2.0, 0.0}, -heading);
      const Motion motion = push(wall, {0.7, 0.0, heading}, {velocity.x, velocity.y, 0.5}, 200);
      CHECK(motion.pose.x < 1.0);
      CHECK_FALSE(inside(wall, robot(), motion.pose));
    }
  }
}

TEST_CASE("a thin leg inside the reach of the front stops a body too") {
  const std::vector<scene::Solid> leg{scene::make_disc({1.0, 0.03}, 0.01)};
  const Motion motion = push(leg, {0.7, 0.0, 0.0}, {1.2, 0.0, 0.0}, 20);
  CHECK(motion.pose.x < 0.9);
  CHECK_FALSE(inside(leg, robot(), motion.pose));
}

TEST_CASE("passing by closely is no contact") {
  const std::vector<scene::Solid> corner{scene::make_box({1.0, 0.112 + 0.25, 0.0}, 0.5, 0.5)};
  Pose2D pose{0.0, 0.0, 0.0};
  const ShapeIndex shapes = index(corner);
  for (int i = 0; i < 200; ++i) {
    const Motion motion = move(robot(), shapes, {}, pose, {1.2, 0.0, 0.0}, {1.2, 0.0, 0.0}, kSeconds);
    pose = motion.pose;
    CHECK(motion.approach_speed == 0.0);
  }
  CHECK(pose.x == doctest::Approx(2.4));
}

TEST_CASE("contact adds no energy and nothing is entered, among random obstacles") {
  const RigidBody bodies[] = {box_body(), off_centre_body(), triangle_body()};
  std::uint64_t touched = 0;
  for (std::uint64_t seed = 0; seed < cases(600); ++seed) {
    CAPTURE(seed);
    const RngKey key{.seed = seed};
    const RigidBody& body = bodies[seed % 3];
    std::vector<scene::Solid> solids;
    for (std::uint32_t i = 0; i < 12; ++i) {
      const Pose2D middle{uniform(key, i, 0, -0.8, 0.8), uniform(key, i, 1, -0.8, 0.8), uniform(key, i, 2, -3.0, 3.0)};
      solids.push_back(i % 3 == 0
                           ? scene::make_disc(middle.position(), uniform(key, i, 3, 0.01, 0.1))
                           : scene::make_box(middle, uniform(key, i, 3, 0.02, 0.4), uniform(key, i, 4, 0.02, 0.2)));
    }
    Pose2D pose{0.0, 0.0, uniform(key, 50, 0, -3.0, 3.0)};
    if (inside(solids, body, pose)) continue;
    const ShapeIndex shapes = index(solids, body);
    Velocity velocity;
    for (std::uint64_t i = 0; i < 200; ++i) {
      CAPTURE(i);
      if (i % 20 == 0) {
        velocity = {uniform(key, 100 + i, 0, -1.2, 1.2), uniform(key, 100 + i, 1, -1.2, 1.2),
                    uniform(key, 100 + i, 2, -3.0, 3.0)};
      }
      const Motion motion = move(body, shapes, {}, pose, velocity, velocity, kSeconds);
      REQUIRE_FALSE(inside(solids, body, motion.pose));
      REQUIRE(energy(body, motion.velocity) <= energy(body, velocity) * (1.0 + 1e-9));
      touched += motion.touching ? 1 : 0;
      // what is told as a collision was in the way in this step: a step's travel at most from where it ends
      if (motion.approach_speed > 0.0) CHECK(gap(solids, body, motion.pose) < 1e-2);
      pose = motion.pose;
    }
  }
  CHECK(touched > cases(10'000));
}

TEST_CASE("a body that touches a disc to the last bit stays where it is, slides or leaves") {
  // distances of zero round to either side of it: nothing may be divided by what the body does not move
  const RigidBody body = robot();
  for (std::uint64_t seed = 0; seed < cases(20000); ++seed) {
    CAPTURE(seed);
    const RngKey key{.seed = seed};
    const scene::Circle disc{{uniform(key, 0, 0, -5.0, 5.0), uniform(key, 1, 0, -5.0, 5.0)},
                             uniform(key, 2, 0, 0.01, 0.3)};
    const double heading = uniform(key, 3, 0, -3.0, 3.0);
    const Vec2 base = disc.center - rotate({0.125 + disc.radius, 0.0}, heading);
    const Velocity velocity{seed % 4 == 0 ? -0.1 : 0.0, seed % 2 == 0 ? 0.0 : 0.3, 0.0};
    const Pose2D pose{base.x, base.y, heading};
    const std::vector<scene::Circle> discs{disc};
    const Motion motion = move(body, index({}), {{}, discs}, pose, velocity, {}, kSeconds);
    CHECK(std::isfinite(motion.pose.x));
    CHECK(std::isfinite(motion.velocity.vx));
    CHECK(distance(motion.pose.position(), pose.position()) < 0.0035);
  }
}

TEST_CASE("other robots stop a body as walls do") {
  const RigidBody body = robot();
  const ShapeIndex nothing;
  std::vector<scene::Segment> other;
  other.reserve(4);
  const std::vector<Vec2> corners = outline(body, {1.0, 0.0, 0.4});
  for (std::size_t i = 0; i < 4; ++i) other.push_back({corners[i], corners[(i + 1) % 4], -1});
  Pose2D pose{0.5, 0.0, 0.0};
  double impact = 0.0;
  Velocity carried{1.0, 0.0, 0.0};
  for (int i = 0; i < 100; ++i) {
    const Motion motion = move(body, nothing, {other, {}}, pose, {1.0, 0.0, 0.0}, carried, kSeconds);
    pose = motion.pose;
    carried = motion.velocity;
    impact = std::max(impact, motion.approach_speed);
    CHECK(pose.x < 1.0);
  }
  CHECK(impact > 0.5);
}
