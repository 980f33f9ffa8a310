#include "safety/creep_mode.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <string>
#include <vector>

#include "draw.hpp"

using namespace threewe;
using namespace threewe::safety;

namespace {

constexpr double kPeriod = to_seconds(kControlPeriod);

double corner_speed(const GateModel& m, const Velocity& v) {
  return std::hypot(v.vx, v.vy) + std::fabs(v.omega) * m.footprint.circumscribed_radius();
}

std::vector<Vec2> wall(Vec2 a, Vec2 b) {
  std::vector<Vec2> points;
  const int n = static_cast<int>(distance(a, b) / 0.01);
  for (int i = 0; i <= n; ++i) points.push_back(a + (static_cast<double>(i) / n) * (b - a));
  return points;
}

// A wall ahead with a doorway in it.
std::vector<Vec2> doorway(double ahead, double width) {
  std::vector<Vec2> points;
  for (const double side : {-1.0, 1.0}) {
    for (const auto& [from, to] : {std::pair(Vec2{ahead, side * 1.0}, Vec2{ahead, side * 0.5 * width}),
                                   std::pair(Vec2{ahead, side * 0.5 * width}, Vec2{ahead + 0.1, side * 0.5 * width})}) {
      const std::vector<Vec2> part = wall(from, to);
      points.insert(points.end(), part.begin(), part.end());
    }
  }
  return points;
}

// Obeys each command a reaction time late, among obstacles that it sees exactly.
struct Driven {
  Driven(const std::string& robot, std::vector<Vec2> around)
      : model(make_gate_model(load_profile(robot))), obstacles(std::move(around)) {
    pipeline.assign(static_cast<std::size_t>(model.reaction / kControlPeriod), Velocity{});
    state.scan_seen = true;
  }
  void drive(const Request& request) {
    now += kControlPeriod;
    state.last_scan = now;
    pipeline.push_back(gate(model, state, request, {obstacles, {}}, now, base).command);
    base = integrate(base, pipeline.front(), kPeriod);
    const double clear = clearance();
    if (clear < nearest) fastest_nearer = std::max(fastest_nearer, corner_speed(model, pipeline.front()));
    nearest = std::min(nearest, clear);
    pipeline.pop_front();
  }
  double clearance() const {
    double least = std::numeric_limits<double>::infinity();
    for (const Vec2 p : obstacles) least = std::min(least, model.footprint.signed_distance(inverse(base) * p));
    return least;
  }

  GateModel model;
  std::vector<Vec2> obstacles;
  GateState state;
  std::deque<Velocity> pipeline;
  Pose2D base;
  Time now{};
  double nearest = std::numeric_limits<double>::infinity();
  double fastest_nearer = 0.0;  // [m/s] of a corner, as it came nearer than ever
};

}  // namespace

TEST_CASE("in creep mode no corner is faster than a touch may be") {
  for (const std::string& name : profile_names()) {
    const GateModel model = make_gate_model(load_profile(name));
    const Limits limits = creep_limits(model);
    CAPTURE(name);
    CHECK(corner_speed(model, {limits.linear, 0.0, limits.angular}) <= 0.05 + 1e-9);
  }
}

TEST_CASE("creep mode keeps the whole margin of a wall ahead") {
  for (const std::string robot : {"3we_standard_v2", "turtlebot_like"}) {
    CAPTURE(robot);
    Driven fast(robot, wall({0.6, -1.0}, {0.6, 1.0}));
    Driven creeping = fast;
    for (int i = 0; i < 1000; ++i) {
      fast.drive({{0.5, 0.0, 0.0}, false});
      creeping.drive({{0.5, 0.0, 0.0}, true});
    }
    CHECK(creeping.nearest >= creeping.model.margin - 1e-6);
    CHECK(creeping.nearest == doctest::Approx(fast.nearest).epsilon(0.01));
  }
}

TEST_CASE("creep mode leads through a passage that is measured to be wide enough, and through no other") {
  for (const std::string robot : {"3we_standard_v2", "turtlebot_like"}) {
    const GateModel model = make_gate_model(load_profile(robot));
    const auto& corners = model.footprint.corners();
    const auto [right, left] = std::ranges::minmax(corners, {}, &Vec2::y);
    const double width = left.y - right.y;
    const auto driven = [&](double spare, bool creep_mode) {
      Driven robot_there(robot, doorway(0.5, width + spare));
      for (int i = 0; i < 1500; ++i) robot_there.drive({{0.5, 0.0, 0.0}, creep_mode});
      return robot_there;
    };
    CAPTURE(robot);
    CHECK(driven(0.03, true).base.x > 1.0);
    CHECK(driven(0.03, true).nearest >= model.creep.margin - 1e-6);
    CHECK(driven(0.03, true).fastest_nearer <= 0.05 + 1e-9);
    CHECK(driven(0.03, false).base.x < 0.5);
    CHECK(driven(-0.02, true).base.x < 0.5);
    CHECK(driven(-0.02, true).fastest_nearer <= 0.05 + 1e-9);  // a touch, at most
  }
}

TEST_CASE("a wall that a lidar measures inside of the body lets it turn in creep mode, as deep as lidars err") {
  for (const std::string robot : {"turtlebot4", "nav2_robot"}) {
    CAPTURE(robot);
    const Driven before(robot, wall({-1.0, -make_gate_model(load_profile(robot)).footprint.inscribed_radius() + 0.008},
                                    {1.0, -make_gate_model(load_profile(robot)).footprint.inscribed_radius() + 0.008}));
    CHECK(before.clearance() == doctest::Approx(-0.008).epsilon(0.01));
    const auto turned = [&](bool creep_mode, double bias) {
      Driven driven = before;
      driven.model.bias = bias;
      for (int i = 0; i < 1000; ++i) driven.drive({{0.0, 0.0, 0.5}, creep_mode});
      return driven;
    };
    const Driven free = turned(true, 0.03);
    CHECK(std::fabs(free.base.theta) > 0.0);
    CHECK(free.nearest >= -0.03);
    CHECK(free.nearest < -0.02);
    CHECK(free.fastest_nearer <= 0.05 + 1e-9);
    CHECK(turned(false, 0.03).base == Pose2D{});
    CHECK(turned(true, 0.008).base == Pose2D{});
    CHECK(turned(true, 0.0).base == Pose2D{});

    // where something is only assumed to be, no lidar erred
    GateState state;
    state.scan_seen = true;
    const Surroundings assumed{{}, before.obstacles};
    CHECK(gate(before.model, state, {{0.0, 0.0, 0.5}, true}, assumed, Time{}).command == Velocity{});
  }
}

TEST_CASE("less than the whole margin is for robots that are as slow as creep mode is, whatever they ask next") {
  int nearer = 0;
  for (std::uint64_t seed = 0; seed < cases(400); ++seed) {
    Draw draw(seed);
    Driven robot(seed % 2 == 0 ? "3we_standard_v2" : "turtlebot_like", {});
    for (int i = 0; i < 12; ++i) {
      const Vec2 at = rotate({draw(0.45, 1.2), 0.0}, draw(-3.0, 3.0));
      const std::vector<Vec2> part = wall(at, at + rotate({draw(0.0, 0.4), 0.0}, draw(-3.0, 3.0)));
      robot.obstacles.insert(robot.obstacles.end(), part.begin(), part.end());
    }
    const double margin = robot.model.margin;
    if (robot.clearance() < margin) continue;
    Velocity velocity;
    bool creep_mode = false;
    for (int i = 0; i < 600; ++i) {
      if (i % 40 == 0) velocity = {draw(-2.0, 2.0), draw(-2.0, 2.0), draw(-3.0, 3.0)};
      if (i % 25 == 0) creep_mode = draw(0.0, 1.0) < 0.8;
      const double before = robot.nearest;
      robot.fastest_nearer = 0.0;
      robot.drive({velocity, creep_mode});
      if (robot.nearest < std::min(before, margin - 1e-6)) {
        ++nearer;
        CAPTURE(seed);
        REQUIRE(robot.fastest_nearer <= 0.05 + 1e-6);
      }
      REQUIRE(robot.nearest >= robot.model.creep.margin - 1e-6);
    }
  }
  CHECK(nearer > static_cast<int>(cases(100)));
}
