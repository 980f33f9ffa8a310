// Robots that meet: what must hold whatever they do.
#include "sim/multi_body_contact.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/rng.hpp"
#include "draw.hpp"
#include "sim/bodies.hpp"

using namespace threewe;
using namespace threewe::sim;

namespace {

constexpr double kSeconds = 0.01;

const RigidBody& body(int kind) {
  static const RigidBody bodies[] = {box_body(), off_centre_body(), triangle_body(), octagon_body()};
  return bodies[kind % 4];
}

struct Momentum {
  Vec2 linear;
  double angular = 0.0;  // about the origin
  double energy = 0.0;
};

Momentum momentum(const std::vector<Mover>& movers) {
  Momentum sum;
  for (const Mover& m : movers) {
    // in the middle of the step
    const Vec2 v = rotate({m.velocity.vx, m.velocity.vy}, m.pose.theta + 0.5 * kSeconds * m.velocity.omega);
    sum.linear = sum.linear + m.body->mass * v;
    sum.angular += m.body->mass * cross(m.pose.position(), v) + m.body->inertia * m.velocity.omega;
    sum.energy += 0.5 * m.body->mass * dot(v, v) + 0.5 * m.body->inertia * m.velocity.omega * m.velocity.omega;
  }
  return sum;
}

bool overlap(const Mover& a, const Pose2D& pose_a, const Mover& b, const Pose2D& pose_b) {
  const std::vector<Vec2> one = outline(*a.body, pose_a);
  const std::vector<Vec2> other = outline(*b.body, pose_b);
  // a corner of one inside the other, or an edge through an edge: by brute force
  for (std::size_t i = 0; i < one.size(); ++i) {
    if (signed_distance(other, one[i]) < -1e-9) return true;
    for (std::size_t j = 0; j < other.size(); ++j) {
      if (signed_distance(one, other[j]) < -1e-9) return true;
      const Vec2 p = one[i];
      const Vec2 r = one[(i + 1) % one.size()] - p;
      const Vec2 q = other[j];
      const Vec2 s = other[(j + 1) % other.size()] - q;
      const double det = cross(r, s);
      if (std::fabs(det) < 1e-12) continue;
      const double t = cross(q - p, s) / det;
      const double u = cross(q - p, r) / det;
      if (t > 1e-6 && t < 1.0 - 1e-6 && u > 1e-6 && u < 1.0 - 1e-6) return true;
    }
  }
  return false;
}

// Up to five bodies close together, none overlapping, moving any way.
std::vector<Mover> random_bodies(std::uint64_t seed) {
  const RngKey key{.seed = seed, .stream = Stream::sampler};
  std::uint64_t n = 0;
  const auto draw = [&](double low, double high) { return uniform(key, n++, 0, low, high); };
  const auto count = static_cast<std::size_t>(draw(2.0, 5.99));
  std::vector<Mover> movers;
  for (int tries = 0; movers.size() < count && tries < 200; ++tries) {
    Mover mover;
    mover.body = &body(static_cast<int>(draw(0.0, 4.0)));
    mover.pose = {draw(-0.35, 0.35), draw(-0.35, 0.35), draw(-M_PI, M_PI)};
    mover.carried = mover.velocity = {draw(-1.2, 1.2), draw(-1.2, 1.2), draw(-3.0, 3.0)};
    const bool free =
        std::ranges::none_of(movers, [&](const Mover& m) { return overlap(m, m.pose, mover, mover.pose); });
    if (free) movers.push_back(mover);
  }
  return movers;
}

}  // namespace

TEST_CASE("impacts keep momentum and never add energy, in thousands of random crowds") {
  std::uint64_t met = 0;
  for (std::uint64_t seed = 0; seed < cases(4000); ++seed) {
    CAPTURE(seed);
    std::vector<Mover> movers = random_bodies(seed);
    const Momentum before = momentum(movers);
    exchange_momentum(movers, kSeconds);
    const Momentum after = momentum(movers);
    CHECK(distance(after.linear, before.linear) < 1e-9);
    CHECK(std::fabs(after.angular - before.angular) < 1e-9);
    CHECK(after.energy <= before.energy + 1e-6);
    met += after.energy < before.energy - 1e-3 ? 1 : 0;
  }
  CHECK(met > cases(250));
}

TEST_CASE("nobody's place in the list matters") {
  for (std::uint64_t seed = 0; seed < cases(500); ++seed) {
    CAPTURE(seed);
    std::vector<Mover> movers = random_bodies(seed);
    std::vector<Mover> reversed(movers.rbegin(), movers.rend());
    exchange_momentum(movers, kSeconds);
    exchange_momentum(reversed, kSeconds);
    for (std::size_t i = 0; i < movers.size(); ++i) {
      const Mover& same = reversed[movers.size() - 1 - i];
      CHECK(std::fabs(movers[i].velocity.vx - same.velocity.vx) < 1e-9);
      CHECK(std::fabs(movers[i].velocity.vy - same.velocity.vy) < 1e-9);
      CHECK(std::fabs(movers[i].velocity.omega - same.velocity.omega) < 1e-9);
      CHECK(movers[i].approach_speed == doctest::Approx(same.approach_speed));
    }
  }
}

TEST_CASE("crowds that move for a while never overlap, and seldom have to stand still") {
  int stood = 0;
  int moved_at_all = 0;
  for (std::uint64_t seed = 0; seed < cases(400); ++seed) {
    CAPTURE(seed);
    std::vector<Mover> movers = random_bodies(seed);
    for (int step = 0; step < 40; ++step) {
      exchange_momentum(movers, kSeconds);
      std::vector<Pose2D> moved;
      moved.reserve(movers.size());
      for (const Mover& m : movers) moved.push_back(integrate(m.pose, m.velocity, kSeconds));
      const std::vector<bool> stays = must_stay(movers, moved);
      for (std::size_t i = 0; i < movers.size(); ++i) {
        (stays[i] ? stood : moved_at_all) += 1;
        if (stays[i]) movers[i].velocity = {};
        if (!stays[i]) movers[i].pose = moved[i];
      }
      for (std::size_t i = 0; i < movers.size(); ++i) {
        for (std::size_t j = i + 1; j < movers.size(); ++j) {
          REQUIRE_FALSE(overlap(movers[i], movers[i].pose, movers[j], movers[j].pose));
        }
      }
    }
  }
  MESSAGE(stood << " of " << stood + moved_at_all << " steps had to be stood out");
  CHECK(stood < moved_at_all / 20);
}

TEST_CASE("head on, two equal robots stop each other; one that is driven into is pushed along, and not blamed") {
  const RigidBody robot = box_body();
  std::vector<Mover> movers(2);
  movers[0] = {&robot, {}, {0.5, 0.0, 0.0}, {0.5, 0.0, 0.0}, 0.0};
  movers[1] = {&robot, {0.251, 0.0, M_PI}, {0.5, 0.0, 0.0}, {0.5, 0.0, 0.0}, 0.0};
  exchange_momentum(movers, kSeconds);
  CHECK(std::fabs(movers[0].velocity.vx) < 0.03);  // the room to the skin is used up in this step
  CHECK(movers[0].velocity.vx == doctest::Approx(movers[1].velocity.vx));
  CHECK(movers[0].approach_speed == doctest::Approx(0.5));
  CHECK(movers[1].approach_speed == doctest::Approx(0.5));

  movers[0] = {&robot, {}, {0.5, 0.0, 0.0}, {0.5, 0.0, 0.0}, 0.0};
  movers[1] = {&robot, {0.2505, 0.0, 0.0}, {}, {}, 0.0};
  exchange_momentum(movers, kSeconds);
  CHECK(movers[0].velocity.vx == doctest::Approx(0.25).epsilon(0.01));
  CHECK(movers[1].velocity.vx == doctest::Approx(0.25).epsilon(0.01));
  CHECK(movers[0].approach_speed == doctest::Approx(0.5));
  CHECK(movers[1].approach_speed == 0.0);
}

TEST_CASE("bodies that do not meet keep their velocities to the bit") {
  const RigidBody robot = box_body();
  std::vector<Mover> movers(2);
  movers[0] = {&robot, {}, {}, {0.3, 0.1, 0.7}, 0.0};
  movers[1] = {&robot, {0.4, 0.0, 1.0}, {}, {0.1, 0.2, 0.3}, 0.0};
  exchange_momentum(movers, kSeconds);
  CHECK(movers[0].velocity == Velocity{0.3, 0.1, 0.7});
  CHECK(movers[1].velocity == Velocity{0.1, 0.2, 0.3});
}
