// People who walk through rooms of random furniture, seen by a lidar that moves itself.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "core/exact.hpp"
#include "core/rng.hpp"
#include "draw.hpp"
#include "perception/people_tracker.hpp"

using namespace threewe;
using perception::PeopleTracker;
using perception::TrackedPerson;

namespace {

struct Circle {
  Vec2 at;
  double radius;
};

// A walker on a straight line, who may stop.
struct Walker {
  Vec2 from;
  Vec2 velocity;
  double stops = 1e9;  // [s]
  Vec2 at(double t) const { return from + std::min(t, stops) * velocity; }
};

// A room with thin and thick poles, of a seed.
struct Room {
  explicit Room(std::uint64_t seed) : key{.seed = seed} {
    half = {uniform(key, 0, 0, 3.5, 5.0), uniform(key, 0, 1, 3.0, 5.0)};
    for (std::uint64_t i = 0; i < 20; ++i) {
      const Vec2 at{uniform(key, 1, static_cast<std::uint32_t>(2 * i), -half.x, half.x),
                    uniform(key, 1, static_cast<std::uint32_t>(2 * i + 1), -half.y, half.y)};
      // along the walls, so that ways stay free
      const bool aside = std::fabs(at.x) > half.x - 0.8 || std::fabs(at.y) > half.y - 0.8;
      if (aside) poles.push_back({at, i % 2 == 0 ? 0.02 : 0.25});
    }
  }
  double range(Vec2 from, double angle, const std::vector<Circle>& legs) const {
    const Vec2 d{std::cos(angle), std::sin(angle)};
    double nearest = std::min(d.x != 0.0 ? ((d.x > 0.0 ? half.x : -half.x) - from.x) / d.x : 1e9,
                              d.y != 0.0 ? ((d.y > 0.0 ? half.y : -half.y) - from.y) / d.y : 1e9);
    const auto meet = [&](const Circle& c) {
      const Vec2 to = c.at - from;
      const double along = dot(to, d);
      const double aside = cross(d, to);
      if (along <= 0.0 || std::fabs(aside) > c.radius) return;
      nearest = std::min(nearest, along - std::sqrt(c.radius * c.radius - aside * aside));
    };
    for (const Circle& c : poles) meet(c);
    for (const Circle& c : legs) meet(c);
    return nearest;
  }
  RngKey key;
  Vec2 half;
  std::vector<Circle> poles;
};

std::vector<Circle> legs_of(const std::vector<Walker>& walkers, double t) {
  std::vector<Circle> legs;
  for (const Walker& walker : walkers) {
    const double speed = norm(walker.velocity);
    const Vec2 ahead = (1.0 / speed) * walker.velocity;
    const double swing = 0.085 * std::sin(2.0 * exact::kPi * speed * std::min(t, walker.stops) / 1.4);
    const Vec2 leg = swing * ahead + 0.09 * Vec2{-ahead.y, ahead.x};
    legs.push_back({walker.at(t) + leg, 0.062});
    legs.push_back({walker.at(t) - leg, 0.062});
  }
  return legs;
}

// A robot that drives in an arc through a room and turns its lidar ten times a second.
struct Watch {
  Watch(std::uint64_t seed, std::vector<Walker> people, bool drives)
      : room(seed), walkers(std::move(people)), velocity{drives ? 0.3 : 0.0, 0.0, drives ? 0.5 : 0.0} {}

  Pose2D lidar(double t) const { return integrate({}, velocity, t); }
  void turn() {
    LaserScan scan;
    scan.angle_min = -exact::kPi;
    scan.angle_increment = 2.0 * exact::kPi / 360.0;
    scan.range_min = 0.02;
    scan.range_max = 12.0;
    scan.time_increment = -0.1 / 360.0;  // clockwise
    for (std::size_t i = 0; i < 360; ++i) {
      const double t = now + 0.1 * (1.0 - (static_cast<double>(i) + 0.5) / 360.0);
      const Pose2D at = lidar(t);
      const double angle = at.theta + scan.angle_min + static_cast<double>(i) * scan.angle_increment;
      const double range = room.range(at.position(), angle, legs_of(walkers, t));
      const auto lane = static_cast<std::uint32_t>(i);
      const bool lost = uniform(room.key, 1000 + scans, lane) < 0.01;
      const double seen = range + 0.01 * normal(room.key, 2000 + scans, lane);
      scan.ranges.push_back(lost ? 0.0F : static_cast<float>(std::min(seen, 12.0)));
    }
    tracker.update(scan, from_seconds(now), from_seconds(now + 0.1), lidar(now), lidar(now + 0.1));
    now += 0.1;
    ++scans;
  }
  std::vector<TrackedPerson> people() const { return tracker.people(from_seconds(now)); }

  Room room;
  std::vector<Walker> walkers;
  Velocity velocity;
  PeopleTracker tracker;
  double now = 0.0;
  std::uint64_t scans = 0;
};

// Past the robot, at some distance, at a walk.
Walker passing(std::uint64_t seed) {
  const RngKey key{.seed = seed};
  const double speed = uniform(key, 5, 0, 0.6, 1.3);
  const double aside = (seed % 2 == 0 ? 1.0 : -1.0) * uniform(key, 5, 1, 1.2, 2.0);
  return {{-2.5, aside}, {speed, 0.0}};
}

}  // namespace

TEST_CASE("nobody is seen where nobody walks, however the robot drives") {
  int ghosts = 0;
  for (std::uint64_t seed = 0; seed < cases(60); ++seed) {
    Watch watch(seed, {}, true);
    for (int i = 0; i < 60; ++i) watch.turn();
    ghosts += watch.people().empty() ? 0 : 1;
  }
  CHECK(ghosts == 0);
}

TEST_CASE("somebody who walks is one person, where and as fast as they are, with an honest covariance") {
  int looks = 0;
  int missed = 0;
  int more = 0;
  double squared = 0.0;
  double faster = 0.0;
  double normalised = 0.0;
  for (std::uint64_t seed = 0; seed < cases(100); ++seed) {
    Watch watch(seed, {passing(seed)}, seed % 3 != 0);
    std::optional<std::uint32_t> id;
    for (int i = 0; i < 38; ++i) {
      watch.turn();
      if (i < 16) continue;  // looks through, then walks
      ++looks;
      const std::vector<TrackedPerson> people = watch.people();
      if (people.empty()) ++missed;
      if (people.size() != 1) continue;
      if (id && people[0].id != *id) ++more;
      id = people[0].id;
      const Vec2 off = people[0].position - watch.walkers[0].at(watch.now);
      squared += dot(off, off);
      normalised += dot(off, off) / people[0].covariance[0];
      const Vec2 by = people[0].velocity - watch.walkers[0].velocity;
      faster += dot(by, by);
    }
  }
  MESSAGE("missed " << missed << " of " << looks << ", changed " << more << ", off " << std::sqrt(squared / looks)
                    << " m, " << std::sqrt(faster / looks) << " m/s, NEES " << normalised / looks);
  CHECK(missed < looks / 20);
  CHECK(more < 5);
  CHECK(std::sqrt(squared / looks) < 0.12);
  CHECK(std::sqrt(faster / looks) < 0.3);
  CHECK(normalised / looks < 2.6);  // of two degrees of freedom
}

TEST_CASE("people who meet stay two") {
  int kept = 0;
  constexpr int kRooms = 40;
  for (std::uint64_t seed = 0; seed < kRooms; ++seed) {
    Watch watch(seed, {{{-2.2, 1.2}, {0.9, 0.0}}, {{2.2, 2.2}, {-0.9, 0.0}}}, false);
    for (int i = 0; i < 40; ++i) watch.turn();
    const std::vector<TrackedPerson> people = watch.people();
    kept += people.size() == 2 && people[0].velocity.x * people[1].velocity.x < 0.0 ? 1 : 0;
  }
  CHECK(kept >= kRooms * 9 / 10);
}

TEST_CASE("who stops is followed for a while, then is furniture") {
  Watch watch(3, {{{-2.0, 1.5}, {0.8, 0.0}, 2.5}}, false);
  for (int i = 0; i < 35; ++i) watch.turn();
  REQUIRE(watch.people().size() == 1);
  CHECK(norm(watch.people()[0].velocity) < 0.4);
  for (int i = 0; i < 50; ++i) watch.turn();
  CHECK(watch.people().empty());
}

TEST_CASE("a copy goes on as the original does") {
  Watch watch(7, {passing(7)}, true);
  for (int i = 0; i < 20; ++i) watch.turn();
  Watch copy = watch;
  for (int i = 0; i < 15; ++i) {
    watch.turn();
    copy.turn();
    CHECK(watch.people() == copy.people());
  }
}
