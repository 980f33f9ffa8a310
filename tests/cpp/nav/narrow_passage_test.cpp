// Gaps between hits, and robots of both kinds that creep through them without a touch.
#include "nav/narrow_passage.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "draw.hpp"
#include "hardware/parameters.hpp"
#include "safety/params.hpp"

namespace threewe::nav {
namespace {

// The hits on the jambs of a gap, and on the wall beside it, in its own frame: x leads through.
std::vector<Vec2> wall_with_gap(const Pose2D& middle, double width, double thickness, double spacing = 0.005) {
  std::vector<Vec2> hits;
  const int deep = static_cast<int>(thickness / spacing);
  for (const double side : {0.5 * width, -0.5 * width}) {
    for (int i = 0; i <= deep; ++i) hits.push_back(middle * Vec2{-0.5 * thickness + i * thickness / deep, side});
    for (int i = 0; i < 100; ++i) {
      const double y = std::copysign(std::fabs(side) + spacing * i, side);
      hits.push_back(middle * Vec2{-0.5 * thickness, y});
      hits.push_back(middle * Vec2{0.5 * thickness, y});
    }
  }
  return hits;
}

// By the book: the free width along one line, by a look at every hit.
double free_width(const std::vector<Vec2>& hits, const Gap& gap) {
  double left = 0.5;
  double right = 0.5;
  for (const Vec2 hit : hits) {
    const Vec2 p = inverse(gap.middle) * hit;
    if (std::fabs(p.x) > gap.half_length) continue;
    (p.y > 0.0 ? left : right) = std::min(p.y > 0.0 ? left : right, std::fabs(p.y));
  }
  return 2.0 * std::min(left, right);
}

TEST_CASE("the widest way through a gap is found from a rough guess, and is as wide as is said") {
  for (std::uint64_t seed = 0; seed < cases(1000); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    const Pose2D middle = draw.pose(-3.0, 3.0);
    const double width = draw(0.15, 0.4);
    const std::vector<Vec2> hits = wall_with_gap(middle, width, draw(0.05, 0.25));
    const Pose2D guess = middle * Pose2D{draw(-0.02, 0.02), draw(-0.08, 0.08), draw(-0.4, 0.4)};
    const Gap found = widest_way(hits, {guess, 0.2, 0.0}, {});
    CHECK(found.width == doctest::Approx(width).epsilon(0.05));
    CHECK(free_width(hits, found) == doctest::Approx(found.width).epsilon(0.02));
    const Pose2D off = inverse(middle) * found.middle;
    CHECK(std::fabs(off.theta) < 0.1);
    CHECK(std::fabs(off.y - off.x * std::tan(off.theta)) < 0.01);
  }
}

struct Crossing {
  NarrowPassage::State end;
  double least_clearance = 1.0;
  bool crept = true;  // wherever the robot was beside the jambs
  bool went_back = false;
};

// A robot that does at once what it is told, before a gap; its idea of the gap is rough.
Crossing cross(const RobotProfile& profile, const std::vector<Vec2>& hits, Pose2D base, const Pose2D& guess) {
  using State = NarrowPassage::State;
  const auto params = params_for<Params>(profile, "nav");
  NarrowPassage narrow_passage(profile, params);
  PathFollower follower(profile, params);
  Time now{};
  narrow_passage.begin(now, base, guess, 0.2, hits);
  Crossing crossing{State::idle};
  for (int tick = 0; tick < 6000; ++tick, now += kControlPeriod) {
    follower.update(transformed(inverse(base), hits), 0.004 - safety::margin_of(profile));
    const Velocity v = narrow_passage.step(now, base, hits, follower);
    base = integrate(base, v, to_seconds(kControlPeriod));
    double clearance = 1.0;
    for (const Vec2 hit : hits) {
      clearance = std::min(clearance, profile.body.footprint.signed_distance(inverse(base) * hit));
    }
    crossing.least_clearance = std::min(crossing.least_clearance, clearance);
    if (clearance < 0.03 && !narrow_passage.creep_mode()) crossing.crept = false;
    crossing.end = narrow_passage.state();
    if (crossing.end == State::backing_out) crossing.went_back = true;
    if (crossing.end != State::lining_up && crossing.end != State::entering && crossing.end != State::backing_out)
      break;
  }
  return crossing;
}

// Where it lines up for a gap in a frame of its own.
Pose2D before_gap(const RobotProfile& profile) {
  return {NarrowPassage(profile, params_for<Params>(profile, "nav")).entry(0.2), 0.0, 0.0};
}

Crossing cross_gap(const RobotProfile& profile, double spare, Draw& draw) {
  double low = 0.0;
  double high = 0.0;
  for (const Vec2 c : profile.body.footprint.corners()) low = std::min(low, c.y), high = std::max(high, c.y);
  const Pose2D middle = draw.pose(-3.0, 3.0);
  const double thickness = draw(0.06, 0.25);
  const std::vector<Vec2> hits = wall_with_gap(middle, high - low + spare, thickness);
  const Pose2D off{-draw(0.0, 0.1), draw(-0.04, 0.04), draw(-0.5, 0.5)};
  const Pose2D base = middle * (before_gap(profile) * off);
  return cross(profile, hits, base, middle * Pose2D{draw(-0.03, 0.03), draw(-0.03, 0.03), draw(-0.3, 0.3)});
}

TEST_CASE("what stands in the way beyond a gap does not send a robot back through it") {
  const RobotProfile profile = load_profile("3we_standard_v2");
  std::vector<Vec2> hits = wall_with_gap({}, 2.0 * profile.body.footprint.inscribed_radius() + 0.1, 0.3);
  for (int i = 0; i < 20; ++i) hits.push_back({0.4 + 0.005 * i, -0.08});
  const Crossing crossing = cross(profile, hits, before_gap(profile), {});
  CHECK(crossing.end == NarrowPassage::State::through);
  CHECK_FALSE(crossing.went_back);
}

TEST_CASE("both kinematics pass gaps 4 cm wider than they are and touch nothing; what is narrower they leave alone") {
  for (const char* name : {"3we_standard_v2", "turtlebot_like"}) {
    const RobotProfile profile = load_profile(name);
    for (std::uint64_t seed = 0; seed < cases(40); ++seed) {
      CAPTURE(std::string(name));
      CAPTURE(seed);
      Draw draw(seed);
      const Crossing through = cross_gap(profile, 0.04, draw);
      CHECK(through.end == NarrowPassage::State::through);
      CHECK(through.least_clearance > 0.003);
      CHECK(through.crept);
      const Crossing narrow = cross_gap(profile, -0.005, draw);
      CHECK(narrow.end == NarrowPassage::State::too_narrow);
      CHECK(narrow.least_clearance > 0.0);
      CHECK(cross_gap(profile, 0.5, draw).end == NarrowPassage::State::wide);
    }
  }
}

}  // namespace
}  // namespace threewe::nav
