// The localiser in a small world with bad sensors: what it says, and what is true.
#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "slam/tiny_world.hpp"
#include "threewe/slam/scan_matching_localizer.hpp"

namespace threewe::slam {
namespace {

using testing::add_box;
using testing::TinyErrors;
using testing::TinyWall;
using testing::TinyWorld;

SensorModel model() {
  SensorModel sensors;
  sensors.lateral_scale = 0.915;
  sensors.lateral_scale_sigma = 0.04;
  return sensors;
}

std::vector<TinyWall> room() {
  std::vector<TinyWall> walls;
  add_box(walls, {-3, -2}, {4, 3});
  add_box(walls, {2.5, 1.0}, {3.0, 2.0});
  add_box(walls, {-2.0, -1.5}, {-1.4, -1.2});
  return walls;
}

TEST_CASE("a robot that turns fast sees its room undistorted") {
  // a scan is measured over 100 ms, in which the robot turns by 10 degrees
  TinyWorld world(room(), {}, {}, 1);
  const auto localizer = make_scan_matching_localizer(model());
  double worst = 0.0;
  for (int tick = 0; tick < 400; ++tick) {
    for (const Sample& s : world.tick({0.1, 0.0, 1.8})) localizer->add(s);
    const PoseEstimate e = localizer->estimate(world.now());
    if (tick < 50) continue;
    for (const Vec2 p : localizer->obstacles()) {
      const Vec2 in_map = e.map_from_odom * p;
      double nearest = 1e9;
      for (const TinyWall& w : world.walls()) {
        const Vec2 d = w.b - w.a;
        const double t = std::clamp(dot(in_map - w.a, d) / dot(d, d), 0.0, 1.0);
        nearest = std::min(nearest, distance(in_map, w.a + t * d));
      }
      worst = std::max(worst, nearest);
    }
  }
  CHECK(worst < 0.05);
}

TEST_CASE("with every sensor wrong the pose stays right") {
  double worst = 0.0;
  double surprise = 0.0;  // squared error over its stated variance, 2 on average where both are right
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    CAPTURE(seed);
    const RngKey key{seed, 0, 0, 0, Stream::episode};
    const TinyErrors errors{uniform(key, 0, 0, 0.985, 1.015),
                            uniform(key, 1, 0, 0.85, 0.98),
                            uniform(key, 2, 0, -0.0087, 0.0087),
                            0.0017,
                            0.01,
                            uniform(key, 3, 0, -0.03, 0.03)};
    TinyWorld world(room(), {}, errors, seed);
    const auto localizer = make_scan_matching_localizer(model());
    for (int tick = 0; tick < 1500; ++tick) {
      const double t = tick * 0.02;
      const Velocity v{0.35 * exact::sin(0.7 * t), 0.15 * exact::cos(0.5 * t), 0.9 * exact::sin(0.31 * t)};
      for (const Sample& s : world.tick(v)) localizer->add(s);
      const PoseEstimate e = localizer->estimate(world.now());
      worst = std::max(worst, distance(e.map_from_base().position(), world.pose().position()));
      CHECK_FALSE(e.lost);
    }
    const PoseEstimate e = localizer->estimate(world.now());
    CHECK(distance(e.map_from_base().position(), world.pose().position()) < 0.04);
    CHECK(std::fabs(wrap_angle(e.map_from_base().theta - world.pose().theta)) < 0.015);
    CHECK(e.covariance[0] > 0.0);
    CHECK(e.covariance[8] > 0.0);
    const Vec2 off = e.map_from_base().position() - world.pose().position();
    const double det = e.covariance[0] * e.covariance[4] - e.covariance[1] * e.covariance[3];
    surprise +=
        (e.covariance[4] * off.x * off.x - 2 * e.covariance[1] * off.x * off.y + e.covariance[0] * off.y * off.y) /
        (12 * det);
  }
  CHECK(worst < 0.06);
  CHECK(surprise > 0.1);
  CHECK(surprise < 6.0);
}

TEST_CASE("odom is smooth whatever corrections do to the map's place in it") {
  TinyErrors errors;
  errors.gyro_bias = 0.008;
  errors.range_sigma = 0.01;
  TinyWorld world(room(), {}, errors, 3);
  const auto localizer = make_scan_matching_localizer(model());
  Pose2D last;
  for (int tick = 0; tick < 800; ++tick) {
    for (const Sample& s : world.tick({0.3, 0.0, 0.6})) localizer->add(s);
    const Pose2D now = localizer->estimate(world.now()).odom_from_base;
    CHECK(distance(now.position(), last.position()) < 0.3 * 0.02 * 1.1);
    CHECK(std::fabs(wrap_angle(now.theta - last.theta)) < 0.6 * 0.02 * 1.2);
    last = now;
  }
}

TEST_CASE("without a lidar, wheels and gyro carry the pose") {
  TinyWorld world({}, {}, {}, 4);
  const auto localizer = make_scan_matching_localizer(SensorModel{});
  for (int tick = 0; tick < 500; ++tick) {
    for (const Sample& s : world.tick({0.3, 0.0, 0.4})) {
      if (!std::holds_alternative<LaserScan>(s.data)) localizer->add(s);
    }
  }
  const PoseEstimate e = localizer->estimate(world.now());
  CHECK(distance(e.map_from_base().position(), world.pose().position()) < 0.02);
  CHECK(localizer->map_version() == 0);
  CHECK(e.covariance[0] > 0.0);
}

TEST_CASE("a robot that is carried away says that it is lost") {
  TinyWorld world(room(), {}, {}, 5);
  const auto localizer = make_scan_matching_localizer(model());
  for (int tick = 0; tick < 200; ++tick) {
    for (const Sample& s : world.tick({})) localizer->add(s);
  }
  CHECK_FALSE(localizer->estimate(world.now()).lost);

  // the same robot in quite another room
  std::vector<TinyWall> elsewhere;
  add_box(elsewhere, {-0.7, -0.9}, {1.1, 0.6});
  world.walls() = elsewhere;
  for (int tick = 0; tick < 250; ++tick) {
    for (const Sample& s : world.tick({})) localizer->add(s);
  }
  CHECK(localizer->estimate(world.now()).lost);
}

TEST_CASE("what the lidar is too near to see stays an obstacle, until the robot is away") {
  std::vector<TinyWall> walls = room();
  TinyWorld world(walls, {}, {}, 6);
  const auto localizer = make_scan_matching_localizer(model());
  const auto drive = [&](const Velocity& v, int ticks) {
    for (int tick = 0; tick < ticks; ++tick) {
      for (Sample s : world.tick(v)) {
        // this lidar is blind within 30 cm
        if (auto* scan = std::get_if<LaserScan>(&s.data)) {
          scan->range_min = 0.3;
          for (float& r : scan->ranges) r = r < 0.3F ? 0.0F : r;
        }
        localizer->add(s);
      }
    }
  };
  const auto nearest = [&] {
    const Vec2 here = localizer->estimate(world.now()).odom_from_base.position();
    double least = 1e9;
    for (const Vec2 p : localizer->obstacles()) least = std::min(least, distance(p, here));
    return least;
  };
  drive({0.3, 0.0, 0.0}, 635);  // to 20 cm before the wall at x = 4
  CHECK(world.pose().x > 3.75);
  CHECK(nearest() < 0.26);
  drive({-0.3, 0.0, 0.0}, 200);
  CHECK(nearest() > 0.3);
}

}  // namespace
}  // namespace threewe::slam
