#include "policy/recovery.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "draw.hpp"

using namespace threewe;
using policy::Recovery;

namespace {

constexpr Duration kTick = from_seconds(0.02);
const Velocity kForward{0.4, 0.0, 0.0};

// Of a lidar whose only hit is at `hit` [m] in the base frame.
LaserScan scan_of(const RobotProfile& profile, Vec2 hit) {
  LaserScan scan{0.0, 0.01, 0.0, 0.02, 12.0, std::vector<float>(629, 12.0F)};
  const Vec2 seen = hit - profile.lidar->base_from_lidar.position();
  const double angle = std::atan2(seen.y, seen.x);
  const auto beam = static_cast<std::size_t>(std::lround((angle < 0.0 ? angle + 2.0 * M_PI : angle) / 0.01));
  scan.ranges[std::min(beam, scan.ranges.size() - 1)] = static_cast<float>(norm(seen));
  return scan;
}

// What is asked for in each of so many ticks, in which the gate stops all or nothing.
std::vector<Velocity> ticks(Recovery& recovery, Time& now, int count, const Velocity& wanted, bool stopped,
                            const LaserScan* scan) {
  std::vector<Velocity> asked;
  for (int i = 0; i < count; ++i, now += kTick) asked.push_back(recovery.next(now, wanted, stopped, scan));
  return asked;
}

// The definition, by trying: of 720 directions, the one in which a small step makes the gap grow most.
Vec2 steepest(const Footprint& footprint, std::span<const Vec2> points) {
  const auto gap = [&](Vec2 moved) {
    double least = std::numeric_limits<double>::infinity();
    for (const Vec2 point : points) least = std::min(least, footprint.signed_distance(point - moved));
    return least;
  };
  Vec2 best;
  double most = -std::numeric_limits<double>::infinity();
  for (int i = 0; i < 720; ++i) {
    const Vec2 step{std::cos(i * M_PI / 360.0), std::sin(i * M_PI / 360.0)};
    if (const double grown = gap(1e-4 * step); grown > most) most = grown, best = step;
  }
  return best;
}

}  // namespace

TEST_CASE("what leads away from a point makes the gap grow most") {
  for (std::uint64_t seed = 0; seed < cases(300); ++seed) {
    CAPTURE(seed);
    Draw random(seed);
    const Footprint footprint = Footprint::rectangle(random(0.1, 0.6), random(0.1, 0.6));
    const std::vector<Vec2> points{random.point(-1.0, 1.0)};
    if (std::abs(footprint.signed_distance(points[0])) < 0.01 || footprint.contains(points[0])) continue;
    const Vec2 away = policy::away_from_nearest(footprint, points);
    const Vec2 twin = steepest(footprint, points);
    CHECK(away.x * twin.x + away.y * twin.y > 0.999);
    CHECK(norm(away) == doctest::Approx(1.0));
  }
}

TEST_CASE("what was measured inside the footprint leads out of it, and points on both sides nowhere") {
  const Footprint footprint = Footprint::rectangle(0.4, 0.2);
  const auto away = [&](const std::vector<Vec2>& points) { return policy::away_from_nearest(footprint, points); };
  CHECK(away({{0.19, 0.0}}).x == doctest::Approx(-1.0));
  CHECK(away({{0.0, -0.09}}).y == doctest::Approx(1.0));
  CHECK(away({{0.25, 0.0}, {-0.25, 0.0}}) == Vec2{});
  CHECK(away({{0.25, 0.0}, {-0.35, 0.0}}).x == doctest::Approx(-1.0));
  CHECK(away({}) == Vec2{});
}

TEST_CASE("a robot that is not stopped does what its policy wants, to the bit") {
  const RobotProfile profile = load_profile("3we_standard_v2");
  for (std::uint64_t seed = 0; seed < cases(300); ++seed) {
    CAPTURE(seed);
    Draw random(seed);
    Recovery recovery(profile);
    Time now = from_seconds(random(0.0, 100.0));
    for (int i = 0; i < 100; ++i, now += kTick) {
      const Velocity wanted{random(-1.0, 1.0), random(-1.0, 1.0), random(-2.0, 2.0)};
      const bool stopped = i % 20 != 0 && random.whole(0, 1) == 1;  // for less than half a second
      CHECK(recovery.next(now, wanted, stopped, nullptr) == wanted);
    }
    CHECK(recovery.count() == 0);
  }
}

TEST_CASE("a robot that has been stopped for half a second moves away from what is nearest") {
  const RobotProfile profile = load_profile("3we_standard_v2");
  const LaserScan scan = scan_of(profile, {0.10, -0.14});  // at its right front wheel
  Recovery recovery(profile);
  Time now{};
  const std::vector<Velocity> before = ticks(recovery, now, 25, kForward, true, &scan);
  CHECK(std::ranges::count(before, kForward) == 25);
  const std::vector<Velocity> away = ticks(recovery, now, 25, kForward, true, &scan);
  CHECK(away.front().vy == doctest::Approx(0.3 * profile.operating_limits.linear));
  CHECK(std::abs(away.front().vx) < 0.01);
  CHECK(std::ranges::count(away, away.front()) == 25);
  CHECK(ticks(recovery, now, 1, kForward, false, &scan)[0] == kForward);
  CHECK(recovery.count() == 1);
}

TEST_CASE("it moves farther when it is stopped again, and less far once that is long ago") {
  const RobotProfile profile = load_profile("3we_standard_v2");
  const LaserScan scan = scan_of(profile, {0.10, -0.14});
  Recovery recovery(profile);
  Time now{};
  std::vector<int> lengths;
  for (int i = 0; i < 5; ++i) {
    CHECK(std::ranges::count(ticks(recovery, now, 25, kForward, true, &scan), kForward) == 25);  // its policy's turn
    int length = 0;
    for (; recovery.next(now, kForward, true, &scan) != kForward; now += kTick) ++length;
    lengths.push_back(length);
  }
  CHECK(lengths == std::vector<int>{25, 40, 64, 100, 100});
  now += from_seconds(4.0);
  recovery.next(now, kForward, false, &scan);
  ticks(recovery, now, 25, kForward, true, &scan);
  const std::vector<Velocity> asked = ticks(recovery, now, 30, kForward, true, &scan);
  CHECK(std::ranges::count(asked, kForward) == 5);
  CHECK(recovery.count() == 6);
}

TEST_CASE("a policy that wants to stand is left alone") {
  Recovery recovery(load_profile("3we_standard_v2"));
  Time now{};
  const std::vector<Velocity> asked = ticks(recovery, now, 200, Velocity{}, true, nullptr);
  CHECK(std::ranges::count(asked, Velocity{}) == 200);
}

TEST_CASE("without a lidar it goes back, and a differential base leaves forwards what is behind it alone") {
  Time now{};
  Recovery blind(load_profile("3we_standard_v2"));
  CHECK(ticks(blind, now, 26, {0.3, 0.4, 0.0}, true, nullptr).back().vy == doctest::Approx(-0.12));
  const RobotProfile profile = load_profile("turtlebot_like");
  for (const auto& [hit, ahead] :
       {std::pair{Vec2{0.2, 0.0}, false}, {Vec2{0.0, 0.2}, false}, {Vec2{-0.25, 0.0}, true}}) {
    Recovery recovery(profile);
    const LaserScan scan = scan_of(profile, hit);
    const Velocity asked = ticks(recovery, now, 26, {0.0, 0.0, 1.0}, true, &scan).back();
    CHECK(asked.vx * (ahead ? 1.0 : -1.0) == doctest::Approx(0.3 * profile.operating_limits.linear));
    CHECK(asked.vy == 0.0);
  }
}
