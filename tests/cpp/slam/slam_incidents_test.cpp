// Mapping on its own, when lidar, odometry or the robot's place are not what they seem.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <vector>

#include "slam/tour.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/slam/slam.hpp"

namespace threewe::slam {
namespace {

using testing::building;
using testing::look;
using testing::TinyWall;
using testing::Tour;
using testing::tour;

constexpr Vec2 kElsewhere{200.0, 0.0};  // another building, as far as the walls of the first are concerned

/// A log as it is recorded, and the truth about it.
struct Recording {
  std::vector<Pose2D> truth;
  std::vector<Pose2D> odometry;
  std::vector<LaserScan> scans;
};

Recording record(const std::vector<TinyWall>& walls, const Tour& way, Draw& draw) {
  Recording log{way.truth, way.odometry, {}};
  for (const Pose2D& pose : way.truth) log.scans.push_back(look(walls, pose, {}, draw));
  return log;
}

/// The same robot, taken from scan `at` to where it was at scan `to` without its odometer moving.
Tour carried(const Tour& way, std::size_t at, std::size_t to) {
  Tour carried;
  for (std::size_t i = 0; i < way.truth.size() + at - to; ++i) {
    const std::size_t k = i < at ? i : i - at + to;
    carried.truth.push_back(way.truth[k]);
    const Pose2D& odometry = way.odometry[k];
    carried.odometry.push_back(i < at ? odometry : way.odometry[at - 1] * inverse(way.odometry[to - 1]) * odometry);
  }
  return carried;
}

Slam mapped(const Recording& log, bool with_odometry = true) {
  Slam slam;
  for (std::size_t i = 0; i < log.scans.size(); ++i) {
    const auto stamp = from_seconds(static_cast<double>(i));
    with_odometry ? slam.add(stamp, log.scans[i], log.odometry[i]) : slam.add(stamp, log.scans[i]);
  }
  return slam;
}

std::vector<SlamEvent> events_of(const Slam& slam, SlamIncident incident) {
  std::vector<SlamEvent> events = slam.events();
  std::erase_if(events, [&](const SlamEvent& event) { return event.incident != incident; });
  return events;
}

/// How far off the poses of the map's component are at most [m], the scans in `without` aside.
double worst(const Slam& slam, const Recording& log, std::size_t from = 0, std::size_t to = 0) {
  double worst = 0.0;
  const std::vector<StampedPose> poses = slam.trajectory();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (poses[i].component != 0 || (i >= from && i < to)) continue;
    worst = std::max(worst, distance(poses[i].map_from_base.position(), log.truth[i].position()));
  }
  return worst;
}

/// The share of occupied cells that are at a wall.
double sharpness(const map::OccupancyGrid& map, const std::vector<TinyWall>& walls) {
  int occupied = 0;
  int at_wall = 0;
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      if (map.at({x, y}) < map::OccupancyGrid::kOccupiedThreshold) continue;
      ++occupied;
      double nearest = 1e9;
      for (const TinyWall& w : walls) {
        nearest = std::min(nearest, distance_to_segment(map.center({x, y}), w.a, w.b));
      }
      at_wall += nearest < 0.15 ? 1 : 0;
    }
  }
  REQUIRE(occupied > 200);
  return static_cast<double>(at_wall) / occupied;
}

TEST_CASE("nothing is noticed where nothing is wrong") {
  for (std::uint64_t seed = 0; seed < cases(8); ++seed) {
    for (const double stride : {0.05, 0.5, 0.8}) {
      CAPTURE(seed);
      CAPTURE(stride);
      Draw draw(seed);
      const std::vector<TinyWall> walls = building(draw);
      CHECK(mapped(record(walls, tour(draw, stride < 0.1 ? 15.0 : 80.0, stride), draw)).events().empty());
    }
  }
}

TEST_CASE("odometry that is a fifth off is noticed, and corrected") {
  for (std::uint64_t seed = 0; seed < cases(8); ++seed) {
    for (const double factor : {0.8, 1.2}) {
      CAPTURE(seed);
      CAPTURE(factor);
      Draw draw(seed);
      const std::vector<TinyWall> walls = building(draw);
      Recording log = record(walls, tour(draw, 80.0, 0.5), draw);
      std::vector<Pose2D> scaled{log.odometry.front()};
      for (std::size_t i = 1; i < log.odometry.size(); ++i) {
        const Pose2D step = inverse(log.odometry[i - 1]) * log.odometry[i];
        scaled.push_back(scaled.back() * Pose2D{factor * step.x, factor * step.y, step.theta});
      }
      log.odometry = scaled;
      const Slam slam = mapped(log);
      const auto events = events_of(slam, SlamIncident::odometry_scaled);
      REQUIRE(!events.empty());
      CHECK(events.front().begin < from_seconds(60.0));  // after 30 m
      CHECK(worst(slam, log) < 0.3);
    }
  }
}

TEST_CASE("a robot that stands is no incident, with noise and without") {
  for (const double sigma : {0.01, 0.0}) {
    Draw draw(1);
    const std::vector<TinyWall> walls = building(draw);
    Slam slam;
    for (int i = 0; i < 200; ++i) {
      slam.add(from_seconds(0.2 * i), look(walls, {}, {.sigma = sigma}, draw), {3.0, 1.0, 0.5});
    }
    CHECK(slam.events().empty());
    CHECK(norm(slam.trajectory().back().map_from_base.position()) < 0.01);
  }
}

TEST_CASE("a lidar that freezes is noticed, and draws nothing") {
  for (std::uint64_t seed = 0; seed < cases(6); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    const std::vector<TinyWall> walls = building(draw);
    Recording log = record(walls, tour(draw, 120.0), draw);
    for (std::size_t i = 61; i < 70; ++i) log.scans[i] = log.scans[60];
    const Slam slam = mapped(log);
    const auto frozen = events_of(slam, SlamIncident::lidar_frozen);
    REQUIRE(frozen.size() == 1);
    CHECK(frozen[0].begin >= 61s);
    CHECK(frozen[0].begin <= 62s);
    CHECK(frozen[0].end == 69s);
    CHECK(slam.trajectory().back().component == 0);  // what broke off has been joined again
    CHECK(worst(slam, log, 61, 75) < 0.15);
    CHECK(sharpness(slam.map(), walls) > 0.98);
  }
}

TEST_CASE("a robot that was carried within its map is noticed, and found again") {
  for (std::uint64_t seed = 0; seed < cases(6); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    const std::vector<TinyWall> walls = building(draw);
    const Recording log = record(walls, carried(tour(draw, 160.0), 100, 115 + 3 * seed), draw);
    const Slam slam = mapped(log);
    const auto lost = events_of(slam, SlamIncident::track_lost);
    REQUIRE(lost.size() == 1);
    CHECK(lost[0].begin >= 100s);
    CHECK(lost[0].begin <= 103s);
    CHECK(events_of(slam, SlamIncident::components_joined).size() == 1);
    CHECK(slam.trajectory().back().component == 0);
    CHECK(worst(slam, log, 100, 103) < 0.15);
    CHECK(sharpness(slam.map(), walls) > 0.98);
  }
}

TEST_CASE("a robot that was carried to another building leaves the map of the first as it was") {
  for (std::uint64_t seed = 0; seed < cases(6); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    const std::vector<TinyWall> first = building(draw);
    std::vector<TinyWall> walls = building(draw);
    for (TinyWall& w : walls) w = {{w.a.y + kElsewhere.x, 0.7 * w.a.x}, {w.b.y + kElsewhere.x, 0.7 * w.b.x}};
    walls.insert(walls.end(), first.begin(), first.end());
    Tour way = tour(draw, 90.0);
    const Tour there = tour(draw, 8.0, 0.25);
    for (std::size_t i = 0; i < there.truth.size(); ++i) {
      way.truth.push_back(Pose2D{kElsewhere.x, 1.0, 0.5} * there.truth[i]);
      way.odometry.push_back(way.odometry[179] * inverse(there.odometry[0]) * there.odometry[i]);
    }
    const Recording log = record(walls, way, draw);
    const Slam slam = mapped(log);
    CHECK(events_of(slam, SlamIncident::track_lost).size() == 1);
    CHECK(events_of(slam, SlamIncident::components_joined).empty());
    CHECK(worst(slam, log, 180, 182) < 0.1);
    CHECK(sharpness(slam.map(), first) > 0.98);
    CHECK(slam.trajectory().back().component == 1);
    CHECK_FALSE(slam.map(1).data.empty());
    CHECK(slam.map(2).data.empty());

    // it is kept so, too
    const auto path = std::filesystem::temp_directory_path() / "threewe_slam_incidents_test.map";
    slam.save(path);
    const Slam again = Slam::load(path);
    CHECK(again.trajectory() == slam.trajectory());
    CHECK(again.map(1) == slam.map(1));
    std::filesystem::remove(path);
  }
}

TEST_CASE("an odometer that is set to zero on the way does no harm") {
  for (std::uint64_t seed = 0; seed < cases(6); ++seed) {
    for (const double stride : {0.1, 0.5}) {
      CAPTURE(seed);
      CAPTURE(stride);
      Draw draw(seed);
      const std::vector<TinyWall> walls = building(draw);
      Recording log = record(walls, tour(draw, 40.0, stride), draw);
      const auto reset = static_cast<std::size_t>((18.0 + static_cast<double>(seed)) / stride);
      const Pose2D there = log.odometry[reset];
      for (std::size_t i = reset; i < log.odometry.size(); ++i) log.odometry[i] = inverse(there) * log.odometry[i];
      const Slam slam = mapped(log);
      const auto jumps = events_of(slam, SlamIncident::odometry_jumped);
      REQUIRE(jumps.size() == 1);
      CHECK(jumps[0].begin == from_seconds(static_cast<double>(reset)));
      CHECK(slam.events().size() == 1);
      CHECK(worst(slam, log) < 0.1);
    }
  }
}

TEST_CASE("a log of overlapping scans is mapped without odometry") {
  for (std::uint64_t seed = 0; seed < cases(6); ++seed) {
    for (const double stride : {0.02, 0.1}) {
      CAPTURE(seed);
      CAPTURE(stride);
      Draw draw(seed);
      const std::vector<TinyWall> walls = building(draw);
      Recording log = record(walls, tour(draw, 30.0, stride), draw);
      const Slam without = mapped(log, false);
      CHECK(without.events().empty());  // nobody claimed that there is any
      CHECK(worst(without, log) < 0.1);
      CHECK(without.trajectory().back().component == 0);

      std::ranges::fill(log.odometry, Pose2D{4.0, 2.0, 0.1});
      const Slam stopped = mapped(log);
      const auto events = events_of(stopped, SlamIncident::odometry_stopped);
      REQUIRE(events.size() == 1);
      CHECK(events[0].begin < from_seconds(0.3 / stride));
      CHECK(events[0].end == from_seconds(static_cast<double>(log.scans.size() - 1)));
      CHECK(worst(stopped, log) < 0.1);
    }
  }
}

TEST_CASE("without odometry scans that do not overlap make no map, and that is said") {
  Draw draw(2);
  const std::vector<TinyWall> walls = building(draw);
  Recording log = record(walls, tour(draw, 60.0, 2.0), draw);
  std::ranges::fill(log.odometry, Pose2D{});
  const Slam slam = mapped(log);
  CHECK_FALSE(slam.events().empty());
}

}  // namespace
}  // namespace threewe::slam
