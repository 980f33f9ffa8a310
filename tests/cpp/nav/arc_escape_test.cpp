// Out of places that are too tight to turn in: plans in arcs, and robots of both kinds that drive them without a touch.
#include "nav/arc_escape.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "core/exact.hpp"
#include "core/rng.hpp"
#include "draw.hpp"
#include "hardware/parameters.hpp"
#include "safety/params.hpp"

namespace threewe::nav {
namespace {

// All that ship: each can move.
const std::vector<std::string>& robots() {
  static const std::vector<std::string> names = profile_names();
  return names;
}

void add_line(std::vector<Vec2>& points, Vec2 a, Vec2 b) {
  constexpr double kSpacing = 0.01;  // [m]
  const int parts = std::max(1, static_cast<int>(distance(a, b) / kSpacing));
  for (int i = 0; i <= parts; ++i) points.push_back(a + (static_cast<double>(i) / parts) * (b - a));
}

// [m] how far to its right the outline of a robot with this heading reaches.
double depth(const RobotProfile& profile, double heading) {
  double most = 0.0;
  for (const Vec2 c : profile.body.footprint.corners()) most = std::max(most, -rotate(c, heading).y);
  return most;
}

// A robot that does exactly as it is commanded, no faster than the gate lets it in creep mode.
struct Body {
  RobotProfile profile;
  PathFollower follower{profile, params_for<Params>(profile, "nav")};
  Outline outline{profile.body.footprint};
  ArcEscape arc_escape{profile, params_for<Params>(profile, "nav")};
  Params::Creep creep = params_for<Params>(profile, "nav").creep;
  std::vector<Vec2> points{};  // in `odom`
  Pose2D pose{};
  Time now{};
  double least_clearance = 1.0;
  double fastest_where_tight = 0.0;  // [m/s] of its corners in creep mode

  std::vector<Vec2> seen() const { return transformed(inverse(pose), points); }

  bool leaves() {
    arc_escape.begin(now);
    while (now < 120s) {
      follower.update(seen(), 0.004 - safety::margin_of(profile));
      Velocity velocity = arc_escape.step(now, pose, seen(), follower);
      if (arc_escape.over()) break;
      const double corners = exact::hypot(velocity.vx, velocity.vy) +
                             std::fabs(velocity.omega) * profile.body.footprint.circumscribed_radius();
      if (arc_escape.creep_mode()) {
        fastest_where_tight = std::max(fastest_where_tight, corners);
        const double share =
            std::min(1.0, params_for<safety::Params>(profile, "safety").creep.corner_speed / std::max(corners, 1e-9));
        velocity = {share * velocity.vx, share * velocity.vy, share * velocity.omega};
      }
      pose = integrate(pose, velocity, to_seconds(kControlPeriod));
      now += kControlPeriod;
      for (const Vec2 p : seen()) least_clearance = std::min(least_clearance, outline.clearance(p));
    }
    return arc_escape.can_turn(seen());
  }
};

TEST_CASE("whoever stands beside a wall leaves it, and does not touch it") {
  for (const std::string& name : robots()) {
    for (std::uint64_t seed = 0; seed < cases(60); ++seed) {
      CAPTURE(name);
      CAPTURE(seed);
      const RngKey key{.seed = seed};
      Body body{load_profile(name)};
      const double along = seed % 4 < 2 ? 0.0 : uniform(key, 0, 0, -exact::kPi, exact::kPi);
      body.pose.theta = wrap_angle(along + (seed % 2 == 0 ? 0.0 : exact::kPi));
      const double free = uniform(key, 1, 0, 0.001, 0.1);
      const double wall = -depth(body.profile, body.pose.theta) - free;
      add_line(body.points, {-2.0, wall}, {2.0, wall});
      CHECK(body.leaves());
      CHECK(body.least_clearance >= std::min(free, 0.004) - 0.0035);
      CHECK(body.fastest_where_tight <= body.creep.speed + body.creep.corner_speed + 1e-9);
    }
  }
}

TEST_CASE("whoever has driven into a slot too narrow to turn in backs out of it") {
  for (const std::string& name : robots()) {
    for (const double spare : {0.02, 0.05, 0.1}) {
      CAPTURE(name);
      CAPTURE(spare);
      Body body{load_profile(name)};
      const double half = depth(body.profile, 0.0) + 0.5 * spare;
      const double end = std::max(0.2, depth(body.profile, -0.5 * exact::kPi) + 0.02);  // [m] ahead of the base
      for (const double side : {1.0, -1.0}) {
        add_line(body.points, {-0.5, side * half}, {end, side * half});
        add_line(body.points, {-0.5, side * half}, {-0.5, side * 1.5});
      }
      add_line(body.points, {end, -half}, {end, half});
      CHECK(body.leaves());
      CHECK(body.pose.x < -0.5);
      CHECK(body.least_clearance >= 0.0);
    }
  }
}

TEST_CASE("each step keeps the outline clear, and the last ends where there is room to turn") {
  for (std::uint64_t seed = 0; seed < cases(100); ++seed) {
    CAPTURE(seed);
    const RngKey key{.seed = seed};
    const RobotProfile profile = load_profile(robots()[seed % robots().size()]);
    const Outline outline(profile.body.footprint);
    std::vector<Vec2> hits;
    for (std::uint64_t i = 0; i < 12; ++i) {
      const Vec2 p{uniform(key, i, 0, -0.5, 0.5), uniform(key, i, 1, -0.5, 0.5)};
      if (outline.clearance(p) > 0.01) hits.push_back(p);
    }
    const ArcEscapePlanner planner(profile, params_for<Params>(profile, "nav"));
    const std::vector<ArcStep> steps = planner.plan(hits);
    for (const ArcStep& step : steps) {
      for (const Vec2 p : hits) CHECK(outline.clearance(inverse(step.end) * p) >= 0.0069);
    }
    if (!steps.empty() && norm(steps.back().end.position()) < 1.2) {
      CHECK(planner.can_turn(transformed(inverse(steps.back().end), hits)));
    }
  }
}

TEST_CASE("a wall at any distance is left as far as it takes") {
  for (const std::string& name : robots()) {
    for (int i = 0; i < 20; ++i) {
      CAPTURE(name);
      CAPTURE(i);
      const RobotProfile profile = load_profile(name);
      const ArcEscapePlanner planner(profile, params_for<Params>(profile, "nav"));
      const double wall = -depth(profile, 0.0) - 0.01 * (i + 1);
      std::vector<Vec2> hits;
      add_line(hits, {-2.0, wall}, {2.0, wall});
      const std::vector<ArcStep> steps = planner.plan(hits);
      CHECK(steps.empty() == planner.has_room(hits));
      if (!steps.empty()) CHECK(planner.has_room(transformed(inverse(steps.back().end), hits)));
    }
  }
}

TEST_CASE("where there is no way there is no plan, and where there is room there is nothing to do") {
  const RobotProfile profile = load_profile("turtlebot_like");
  const ArcEscapePlanner planner(profile, params_for<Params>(profile, "nav"));
  std::vector<Vec2> box;
  for (const double side : {1.0, -1.0}) {
    add_line(box, {-0.15, side * 0.11}, {0.08, side * 0.11});
    add_line(box, {side > 0.0 ? 0.08 : -0.15, -0.11}, {side > 0.0 ? 0.08 : -0.15, 0.11});
  }
  CHECK_FALSE(planner.can_turn(box));
  CHECK(planner.plan(box).empty());
  CHECK(planner.can_turn({}));
  CHECK(planner.plan({}).empty());
}

}  // namespace
}  // namespace threewe::nav
