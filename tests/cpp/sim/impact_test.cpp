// Impacts at the limits of the hardware, against a slow witness: it follows the free motion in 200 parts a step, and
// watches the distance to what stands there, by the scene's own exact geometry.
#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "core/rng.hpp"
#include "draw.hpp"
#include "sim/bodies.hpp"
#include "sim/contact.hpp"

using namespace threewe;
using namespace threewe::sim;

namespace {

constexpr double kSeconds = 0.01;
constexpr double kMaxSpeed = 1.2;
constexpr double kMaxTurnRate = 3.0;
constexpr int kSteps = 60;
constexpr int kFiner = 200;

// A body on its way at constant velocity to something that stands near (1, 0).
struct Approach {
  RigidBody body;
  std::vector<scene::Solid> solids;
  bool solids_are_robots = false;
  Pose2D pose;
  Velocity velocity;

  ShapeIndex obstacles() const {
    const double reach = contact_reach(body.footprint, kMaxSpeed, kMaxTurnRate, kSeconds);
    return {solids_are_robots ? scene::Slice{} : scene::outlines(solids), reach};
  }
  std::vector<scene::Segment> others() const {
    return solids_are_robots ? scene::outlines(solids).segments : std::vector<scene::Segment>{};
  }
};

Approach random_approach(std::uint64_t seed) {
  const RngKey key{.seed = seed};
  const auto draw = [&](std::uint64_t what, double low, double high) { return uniform(key, what, 0, low, high); };
  const auto choose = [&](std::uint64_t what, int among) { return static_cast<int>(draw(what, 0.0, among)); };
  const RigidBody bodies[] = {box_body(), off_centre_body(), triangle_body(), octagon_body()};
  Approach approach;
  approach.body = bodies[choose(0, 4)];

  const Pose2D middle{1.0, 0.0, draw(1, -M_PI, M_PI)};
  switch (choose(2, 5)) {
    case 0:  // a wall
      approach.solids = {scene::make_box({1.05, 0.0, 0.0}, 0.1, 10.0)};
      break;
    case 1:  // the corners of a box
      approach.solids = {scene::make_box(middle, draw(3, 0.05, 0.6), draw(4, 0.05, 0.6))};
      break;
    case 2:  // the corner of a room
      approach.solids = {scene::make_box({1.05, 0.0, 0.0}, 0.1, 10.0), scene::make_box({0.0, 0.35, 0.0}, 10.0, 0.1)};
      break;
    case 3: approach.solids = {scene::make_disc(middle.position(), draw(3, 0.01, 0.2))}; break;
    default: approach.solids = {scene::make_box(middle, 0.25, 0.22)}; approach.solids_are_robots = true;
  }

  const int kind = choose(5, 4);
  const double speed = kind == 0 ? 0.0 : kind == 1 ? draw(6, 0.1, kMaxSpeed) : kMaxSpeed;
  const double turn_rate = kind == 3 ? 0.0 : draw(7, -1.0, 1.0) < 0.0 ? -kMaxTurnRate : kMaxTurnRate;
  const double farthest = kind == 0 ? 0.4 : 0.6;
  approach.pose = {1.0 - draw(8, 0.15, farthest), draw(9, -0.25, 0.25), draw(10, -M_PI, M_PI)};
  const double course = draw(11, -0.5, 0.5) - approach.pose.theta;
  approach.velocity = {speed * std::cos(course), speed * std::sin(course), turn_rate};
  return approach;
}

// What becomes of an approach that nothing holds back.
struct Witness {
  bool hits = false;   // it enters something, deeper than a millimetre
  bool passes = true;  // it stays half a millimetre away from everything
  double speed = 0.0;  // [m/s] at which the distance shrinks as it first touches
  int steps = 0;       // until it has hit
};

Witness watch(const Approach& approach) {
  constexpr double kPart = kSeconds / kFiner;
  const auto& [body, solids, robots, begin, velocity] = approach;
  const double fastest =
      std::hypot(velocity.vx, velocity.vy) + std::fabs(velocity.omega) * body.footprint.circumscribed_radius();
  Witness witness;
  Pose2D pose = begin;
  bool touching = false;
  for (; witness.steps < kSteps && !witness.hits; ++witness.steps) {
    double before = gap(solids, body, pose);
    for (int i = 1; i <= kFiner && !witness.hits && (touching || before < kSeconds * fastest + 1e-3); ++i) {
      const Pose2D now = integrate(pose, velocity, kPart * i);
      const double distance = gap(solids, body, now);
      if (!touching && distance > 0.0) witness.speed = (before - distance) / kPart;
      touching = distance == 0.0;
      before = distance;
      witness.passes = witness.passes && distance > 5e-4;
      witness.hits = touching && inside(solids, body, now, 1e-3);
    }
    pose = integrate(pose, velocity, kSeconds);
  }
  return witness;
}

// The hardest impact that the code under test records, with each step taken in `parts`.
double record(const Approach& approach, int steps, int parts) {
  const ShapeIndex obstacles = approach.obstacles();
  const std::vector<scene::Segment> others = approach.others();
  Pose2D pose = approach.pose;
  Velocity carried = approach.velocity;
  double hardest = 0.0;
  for (int i = 0; i < steps; ++i) {
    Velocity velocity = approach.velocity;
    for (int part = 0; part < parts; ++part) {
      const Motion motion = move(approach.body, obstacles, {others, {}}, pose, velocity, carried, kSeconds / parts);
      hardest = std::max(hardest, motion.approach_speed);
      pose = motion.pose;
      velocity = carried = motion.velocity;
    }
    REQUIRE_FALSE(inside(approach.solids, approach.body, pose));
  }
  return hardest;
}

}  // namespace

TEST_CASE("every impact at the limits of the hardware is recorded with its speed, and nothing else is") {
  std::uint64_t hits = 0;
  int passes = 0;
  for (std::uint64_t seed = 0; seed < cases(6000); ++seed) {
    CAPTURE(seed);
    const Approach approach = random_approach(seed);
    if (gap(approach.solids, approach.body, approach.pose) < 1e-3) continue;
    const Witness witness = watch(approach);
    if (witness.hits && witness.speed > 0.05) {
      ++hits;
      const double recorded = record(approach, witness.steps + 1, 1);
      CHECK(recorded > 0.8 * witness.speed);
      // where another corner follows, that may be the harder impact: smaller steps tell
      const bool harder = recorded > 1.2 * witness.speed + 0.02;
      if (harder) CHECK(recorded < 1.2 * record(approach, witness.steps + 1, kFiner) + 0.02);
    } else if (witness.passes) {
      ++passes;
      CHECK(record(approach, kSteps, 1) == 0.0);
    }
  }
  CHECK(hits > cases(2000));
  CHECK(passes > 200);
}

TEST_CASE("a wall takes nothing from the motion along it, however the body turns") {
  const std::vector<scene::Solid> wall{scene::make_box({1.05, 0.0, 0.0}, 0.1, 40.0)};
  const RigidBody bodies[] = {box_body(), off_centre_body(), triangle_body(), octagon_body()};
  std::uint64_t touched = 0;
  for (std::uint64_t seed = 0; seed < cases(2000); ++seed) {
    CAPTURE(seed);
    const RngKey key{.seed = seed};
    const RigidBody& body = bodies[seed % 4];
    const ShapeIndex obstacles(scene::outlines(wall), contact_reach(body.footprint, kMaxSpeed, kMaxTurnRate, kSeconds));
    Pose2D pose{0.75, 0.0, uniform(key, 0, 0, -M_PI, M_PI)};
    const double course = uniform(key, 1, 0, -1.4, 1.4);
    const Vec2 world{kMaxSpeed * std::cos(course), kMaxSpeed * std::sin(course)};
    // a velocity is seen from the heading midway through its step
    double turn_rate = uniform(key, 2, 0, -kMaxTurnRate, kMaxTurnRate);
    Vec2 linear = rotate(world, -(pose.theta + 0.5 * kSeconds * turn_rate));
    bool met = false;
    for (int i = 0; i < 50; ++i) {
      const Velocity velocity{linear.x, linear.y, turn_rate};
      const Motion motion = move(body, obstacles, {}, pose, velocity, velocity, kSeconds);
      REQUIRE_FALSE(inside(wall, body, motion.pose));
      met = met || motion.touching;
      pose = motion.pose;
      turn_rate = motion.velocity.omega;
      linear = rotate({motion.velocity.vx, motion.velocity.vy}, -kSeconds * turn_rate);
    }
    const Vec2 after = rotate(linear, pose.theta + 0.5 * kSeconds * turn_rate);
    CHECK(std::fabs(after.y - world.y) < 1e-3);  // an arc followed along its chord loses 4e-5 of it a step
    CHECK(std::fabs(pose.y - 50 * kSeconds * world.y) < 1e-3);
    touched += met ? 1 : 0;
  }
  CHECK(touched > cases(1000));
}

TEST_CASE("a body that slides along one wall meets the next one at its full speed") {
  const std::vector<scene::Solid> walls{scene::make_box({1.05, 0.0, 0.0}, 0.1, 10.0),
                                        scene::make_box({0.0, 1.05, 0.0}, 10.0, 0.1)};
  const RigidBody body = box_body();
  const ShapeIndex obstacles(scene::outlines(walls), contact_reach(body.footprint, kMaxSpeed, kMaxTurnRate, kSeconds));
  for (const double along : {0.1, 0.5, 0.9, 1.1}) {
    CAPTURE(along);
    Pose2D pose{0.86, 0.3, 0.0};
    const Velocity velocity{0.3, along, 0.0};
    Velocity carried = velocity;
    double hardest = 0.0;
    for (int i = 0; i < 800; ++i) {
      const Motion motion = move(body, obstacles, {}, pose, velocity, carried, kSeconds);
      pose = motion.pose;
      carried = motion.velocity;
      hardest = std::max(hardest, motion.approach_speed);
    }
    CHECK(hardest == doctest::Approx(std::max(along, 0.3)).epsilon(1e-6));
    CHECK(pose.y > 0.88);
  }
}
