// A robot that does not get on: what it does, in which order, and when it gives up.
#include "nav/recovery.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/exact.hpp"
#include "core/rng.hpp"
#include "draw.hpp"
#include "hardware/parameters.hpp"
#include "safety/params.hpp"

namespace threewe::nav {
namespace {

using State = Recovery::State;

// A robot that does exactly as it is told, among points.
struct Body {
  RobotProfile profile;
  PathFollower follower;
  Outline outline;
  Recovery recovery;
  Pose2D pose;
  Time now{};
  std::vector<Vec2> points{};
  std::vector<State> states{};  // that it went through
  std::vector<Pose2D> way{};    // since it began
  double least_clearance = 1.0;

  explicit Body(const char* name)
      : profile(load_profile(name)),
        follower(profile, params_for<Params>(profile, "nav")),
        outline(profile.body.footprint),
        recovery(profile, params_for<Params>(profile, "nav")) {}

  void drive(const Velocity& velocity, Duration duration) {
    for (const Time end = now + duration; now < end;) {
      recovery.remember(pose);
      move(velocity);
    }
  }

  // Until it plans anew or gives up.
  void recover() {
    states.clear(), way.clear();
    const Time began = now;
    recovery.begin(now, pose, pose.position());
    while (recovery.state() != State::replanning && recovery.state() != State::given_up) {
      note();
      std::vector<Vec2> in_base;
      for (const Vec2 p : points) in_base.push_back(inverse(pose) * p);
      follower.update(in_base, recovery.creep_mode() ? 0.004 - safety::margin_of(profile) : 0.0);
      move(recovery.step(now, pose, in_base, follower));
      REQUIRE(now - began < 100s);
    }
    note();
    if (recovery.state() == State::replanning) recovery.end();
  }

  void note() {
    way.push_back(pose);
    if (states.empty() || states.back() != recovery.state()) states.push_back(recovery.state());
    for (const Vec2 p : points) least_clearance = std::min(least_clearance, outline.clearance(inverse(pose) * p));
  }

  void move(const Velocity& velocity) {
    pose = integrate(pose, velocity, to_seconds(kControlPeriod));
    now += kControlPeriod;
  }
};

std::vector<Vec2> ring(Vec2 middle, double radius) {
  std::vector<Vec2> points;
  for (int i = 0; i < 120; ++i) points.push_back(middle + rotate({radius, 0.0}, i * exact::kPi / 60));
  return points;
}

TEST_CASE("it clears, backs off the way it came, and plans anew") {
  for (const char* name : {"3we_standard_v2", "turtlebot_like"}) {
    CAPTURE(name);
    Body body(name);
    body.drive({0.2, 0.0, 0.0}, 2s);
    body.drive({0.2, 0.0, 0.5}, 2s);
    const Pose2D before = body.pose;
    body.recover();
    CHECK(body.states == std::vector{State::clearing, State::backing_off, State::replanning});
    CHECK(norm((inverse(before) * body.pose).position()) > 0.1);
    for (const Pose2D& pose : body.way) {
      // on the circle of radius 0.4 m that it came along, or the line before it
      const double off = pose.x < 0.4 ? pose.y : distance(pose.position(), {0.4, 0.4}) - 0.4;
      CHECK(std::fabs(off) < 0.03);
    }
  }
}

TEST_CASE("it backs off farther each time, looks from the third time on, and gives up after eight") {
  Body body("3we_standard_v2");
  double farthest = 0.0;
  for (int attempt = 1; attempt <= 8; ++attempt) {
    CAPTURE(attempt);
    body.drive({0.3, 0.0, 0.0}, 3s);
    body.pose = {};  // carried back to where it could not go on
    body.recover();
    const double backed = norm(body.pose.position());
    if (attempt <= 4) CHECK(backed > farthest);
    farthest = std::max(farthest, backed);
    CHECK((std::ranges::find(body.states, State::looking) != body.states.end()) == (attempt >= 3));
    const auto [least, most] = std::ranges::minmax(body.way, {}, &Pose2D::theta);
    if (attempt >= 3) CHECK(most.theta - least.theta > 1.3);
    CHECK(body.states.back() == State::replanning);
    body.pose = {};
  }
  body.recover();
  CHECK(body.recovery.state() == State::given_up);
  CHECK(body.recovery.reason() == "the way on stays blocked, whatever was tried");
}

TEST_CASE("another place is another beginning") {
  Body body("turtlebot_like");
  for (int attempt = 0; attempt < 20; ++attempt) {
    body.drive({0.3, 0.0, 0.0}, 3s);
    body.recover();
    CHECK(body.states.back() == State::replanning);
  }
}

TEST_CASE("beside a wall, too near to turn, it leaves in arcs") {
  for (const double away : {0.1, 0.12, 0.14, 0.16}) {
    CAPTURE(away);
    Body body("turtlebot_like");
    for (int i = 0; i <= 400; ++i) body.points.push_back({-2.0 + 0.01 * i, -away});
    body.recover();
    CHECK(body.states == std::vector{State::clearing, State::backing_off, State::arc_escape, State::replanning});
    CHECK(body.pose.y > 0.19 - away);  // its corners, and the margin
    CHECK(body.least_clearance >= 0.0);
  }
}

TEST_CASE("who has no room says so") {
  for (const char* name : {"3we_standard_v2", "turtlebot_like"}) {
    CAPTURE(name);
    Body body(name);
    body.points = ring({}, body.profile.body.footprint.circumscribed_radius() + 0.01);
    for (int attempt = 0; attempt < 9; ++attempt) body.recover();
    CHECK(body.recovery.state() == State::given_up);
    CHECK(body.recovery.reason() == "there is no room to move");
    CHECK(body.least_clearance >= 0.0);
  }
}

TEST_CASE("a robot that hears in a few directions looks each time") {
  Body body("3we_base_v2");
  body.recover();
  CHECK(std::ranges::find(body.states, State::looking) != body.states.end());
}

TEST_CASE("a lost robot turns once round itself") {
  Body body("3we_standard_v2");
  body.recovery.look_round(body.now, body.pose);
  double turned = 0.0;
  while (body.recovery.state() == State::looking) {
    const double before = body.pose.theta;
    body.move(body.recovery.step(body.now, body.pose, {}, body.follower));
    turned += wrap_angle(body.pose.theta - before);
    REQUIRE(body.now < 30s);
  }
  CHECK(turned == doctest::Approx(2.0 * exact::kPi).epsilon(0.03));
  CHECK(norm(body.pose.position()) < 0.01);
}

TEST_CASE("whatever stands around, it ends, and runs into nothing") {
  for (std::uint64_t seed = 0; seed < cases(2000); ++seed) {
    CAPTURE(seed);
    const RngKey key{.seed = seed};
    Body body(seed % 2 == 0 ? "3we_standard_v2" : "turtlebot_like");
    const double turn = uniform(key, 0, 0, -0.8, 0.8);
    body.drive({0.3, 0.0, turn}, 3s);
    const int count = static_cast<int>(uniform(key, 1, 0, 0.0, 20.0));
    for (int i = 0; i < count; ++i) {
      const auto lane = static_cast<std::uint64_t>(i) + 2;
      const Vec2 point{uniform(key, lane, 0, -0.6, 0.6), uniform(key, lane, 1, -0.6, 0.6)};
      if (body.outline.clearance(point) > safety::margin_of(body.profile)) body.points.push_back(body.pose * point);
    }
    for (int attempt = 0; attempt < 3; ++attempt) body.recover();
    CHECK(body.least_clearance > -0.01);  // the tracker looks every 2 cm; the gate, which has the last word, more often
  }
}

}  // namespace
}  // namespace threewe::nav
