// The localiser in a small world with bad sensors: what it says, and what is true.
#include <doctest/doctest.h>

#include <cmath>
#include <deque>
#include <memory>
#include <utility>
#include <variant>
#include <vector>

#include "core/exact.hpp"
#include "draw.hpp"
#include "slam/scan_matching_localizer.hpp"
#include "slam/tiny_world.hpp"

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
  for (std::uint64_t seed = 0; seed < cases(12); ++seed) {
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
      CHECK_FALSE(e.lost());
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
  if (!kSanitized) CHECK(surprise > 0.01);  // a room that is seen whole from the beginning is better known than most
  CHECK(surprise < 6.0);
}

TEST_CASE(
    "a robot whose lidar scatters four times as much as it should says that it is less sure, and is not too sure") {
  const auto drive = [](double range_sigma, std::uint64_t seed) {
    TinyWorld world(room(), {}, {.gyro_sigma = 0.0017, .range_sigma = range_sigma}, seed);
    const auto localizer = make_scan_matching_localizer(model());
    for (int tick = 0; tick < 1000; ++tick) {
      const double t = tick * 0.02;
      const Velocity v{0.35 * exact::sin(0.7 * t), 0.0, 0.9 * exact::sin(0.31 * t)};
      for (const Sample& s : world.tick(tick < 50 ? Velocity{} : v)) localizer->add(s);
    }
    return std::pair(localizer->estimate(world.now()), world.pose());
  };
  double surprise = 0.0;  // squared error over what is stated, position alone: 1 on average where it is right
  constexpr std::uint64_t kDrives = cases(10);
  for (std::uint64_t seed = 0; seed < kDrives; ++seed) {
    CAPTURE(seed);
    const auto [good, ignored] = drive(0.01, seed);
    const auto [bad, truth] = drive(0.04, seed);
    const double stated = bad.covariance[0] + bad.covariance[4];
    CHECK(stated > 4.0 * (good.covariance[0] + good.covariance[4]));
    const Vec2 off = bad.map_from_base().position() - truth.position();
    surprise += dot(off, off) / (stated * kDrives);
  }
  CHECK(surprise < 3.0);
}

TEST_CASE("what one sensor says wrongly for three seconds the other two bound, also where nobody notices") {
  enum class Lie { gyro_bias, late_gyro, late_scans, silent_wheels };
  for (const Lie lie : {Lie::gyro_bias, Lie::late_gyro, Lie::late_scans, Lie::silent_wheels}) {
    for (std::uint64_t seed = 0; seed < cases(20); ++seed) {
      CAPTURE(static_cast<int>(lie));
      CAPTURE(seed);
      const RngKey key{.seed = seed};
      TinyWorld world(room(), {}, {.gyro_sigma = 0.0017, .range_sigma = 0.01}, seed);
      const auto localizer = make_scan_matching_localizer(model());
      std::deque<Sample> late;
      double worst = 0.0;
      for (int tick = 0; tick < 600; ++tick) {
        const double t = tick * 0.02;
        const bool lies = tick >= 250 && tick < 400;
        const bool stands = lie == Lie::silent_wheels && lies;  // a robot that misses a sensor stops
        const double turn = uniform(key, static_cast<std::uint64_t>(tick / 25), 0, -1.0, 1.0);
        for (Sample& s : world.tick(stands ? Velocity{} : Velocity{0.3 * exact::cos(0.6 * t), 0.0, turn})) {
          auto* imu = std::get_if<IMUData>(&s.data);
          if (lies && lie == Lie::gyro_bias && imu != nullptr) imu->angular_velocity[2] += 0.087;
          if (lies && lie == Lie::silent_wheels && std::holds_alternative<Odometry>(s.data)) continue;
          const bool is_late = (lie == Lie::late_gyro && imu != nullptr) ||
                               (lie == Lie::late_scans && std::holds_alternative<LaserScan>(s.data));
          if (is_late && lies) {
            late.push_back(s);
            if (late.front().received + 500ms > world.now()) continue;
            Sample delivered = std::exchange(late.front(), {});
            late.pop_front();
            delivered.measured = s.measured;
            s = std::move(delivered);
          }
          localizer->add(s);
        }
        const PoseEstimate e = localizer->estimate(world.now());
        worst = std::max(worst, distance(e.map_from_base().position(), world.pose().position()));
      }
      CHECK(worst < 0.25);
      const double heading = localizer->estimate(world.now()).map_from_base().theta;
      CHECK(std::fabs(wrap_angle(heading - world.pose().theta)) < 0.2);
    }
  }
}

// The sample of a robot of twice the size in a world of twice the size.
Sample doubled(Sample sample) {
  if (auto* odometry = std::get_if<Odometry>(&sample.data)) {
    odometry->pose.x *= 2.0, odometry->pose.y *= 2.0;
    odometry->velocity.vx *= 2.0, odometry->velocity.vy *= 2.0;
  }
  if (auto* scan = std::get_if<LaserScan>(&sample.data)) {
    for (float& range : scan->ranges) range *= 2.0F;
    scan->range_min *= 2.0, scan->range_max *= 2.0;
  }
  return sample;
}

TEST_CASE("a robot of twice the size in a world of twice the size is twice as far off, as it says") {
  Params params;
  scale_parameters(parameters_of(params), {.size = 2.0, .speed = 2.0, .stopping = 2.0, .noise = 2.0, .bias = 2.0});
  SensorModel sensors = model();
  sensors.range_sigma *= 2.0, sensors.range_bias_sigma *= 2.0;
  const auto large = make_scan_matching_localizer(sensors, {}, std::make_shared<const Params>(params));
  const auto small = make_scan_matching_localizer(model());
  TinyWorld world(room(), {}, {1.01, 0.9, 0.005, 0.0017, 0.01, 0.02}, 5);
  for (int tick = 0; tick < 1500; ++tick) {
    const double t = tick * 0.02;
    const Velocity v{0.35 * exact::sin(0.7 * t), 0.15 * exact::cos(0.5 * t), 0.9 * exact::sin(0.31 * t)};
    for (const Sample& s : world.tick(v)) {
      small->add(s);
      large->add(doubled(s));
    }
    const PoseEstimate one = small->estimate(world.now());
    const PoseEstimate two = large->estimate(world.now());
    const Vec2 off = two.map_from_base().position() - 2.0 * one.map_from_base().position();
    CHECK(norm(off) < 0.002);
    CHECK(two.position_uncertainty() == doctest::Approx(2.0 * one.position_uncertainty()).epsilon(0.02));
    CHECK(two.state == one.state);
  }
  CHECK(large->map().resolution == 0.1);
  CHECK(large->map().width == small->map().width);
  CHECK(large->map().height == small->map().height);
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

TEST_CASE("without a lidar, the gyro's bias is learned while the robot stands") {
  TinyErrors errors;
  errors.gyro_bias = 0.008;
  errors.gyro_sigma = 0.0017;
  const auto heading_error = [&](Duration standing) {
    TinyWorld world({}, {}, errors, 5);
    SensorModel sensors = model();
    sensors.lidar = false;
    const auto localizer = make_scan_matching_localizer(sensors);
    while (world.now() < standing + 20s) {
      for (const Sample& s : world.tick(world.now() < standing ? Velocity{} : Velocity{0.2, 0.0, 0.1})) {
        if (!std::holds_alternative<LaserScan>(s.data)) localizer->add(s);
      }
    }
    return std::fabs(wrap_angle(localizer->estimate(world.now()).map_from_base().theta - world.pose().theta));
  };
  CHECK(heading_error(0s) > 0.1);  // 20 s of 0.008 rad/s
  CHECK(heading_error(1s) < 0.02);
}

TEST_CASE("a robot whose lidar has failed learns the gyro's bias while it stands") {
  TinyErrors errors;
  errors.gyro_bias = 0.03;
  errors.gyro_sigma = 0.0017;
  TinyWorld world(room(), {}, errors, 8);
  const auto localizer = make_scan_matching_localizer(model());
  while (world.now() < 60s) {
    for (const Sample& s : world.tick({})) {
      if (world.now() < 200ms || !std::holds_alternative<LaserScan>(s.data)) localizer->add(s);
    }
  }
  CHECK(std::fabs(localizer->estimate(world.now()).map_from_base().theta) < 0.1);  // 1.8 rad by the gyro as it is
}

TEST_CASE("a robot that is carried away says that it is lost") {
  TinyWorld world(room(), {}, {}, 5);
  const auto localizer = make_scan_matching_localizer(model());
  for (int tick = 0; tick < 200; ++tick) {
    for (const Sample& s : world.tick({})) localizer->add(s);
  }
  CHECK_FALSE(localizer->estimate(world.now()).lost());

  // the same robot in quite another room
  std::vector<TinyWall> elsewhere;
  add_box(elsewhere, {-0.7, -0.9}, {1.1, 0.6});
  world.walls() = elsewhere;
  for (int tick = 0; tick < 250; ++tick) {
    for (const Sample& s : world.tick({})) localizer->add(s);
  }
  CHECK(localizer->estimate(world.now()).lost());
}

/// A localiser whose lidar is blind within 30 cm.
class ShortSighted {
 public:
  ShortSighted(const Pose2D& start, const TinyErrors& errors) : world_(room(), start, errors, 6) {}

  void drive(const Velocity& v, int ticks) {
    for (int tick = 0; tick < ticks; ++tick) {
      for (Sample s : world_.tick(v)) {
        if (auto* scan = std::get_if<LaserScan>(&s.data)) {
          scan->range_min = 0.3;
          for (float& r : scan->ranges) r = r < 0.3F ? 0.0F : r;
        }
        localizer_->add(s);
      }
    }
  }

  double nearest_obstacle() const {
    const Vec2 here = localizer_->estimate(world_.now()).odom_from_base.position();
    double least = 1e9;
    for (const Vec2 p : localizer_->obstacles()) least = std::min(least, distance(p, here));
    return least;
  }

  // [m] how far the wall at x = 4, beside the robot, is from obstacles at most.
  double largest_gap() const {
    double largest = 0.0;
    for (int i = -20; i <= 20; ++i) {
      double least = 1e9;
      for (const Vec2 p : localizer_->obstacles()) least = std::min(least, distance(p, {4.0, 0.01 * i}));
      largest = std::max(largest, least);
    }
    return largest;
  }

  const Pose2D& pose() const { return world_.pose(); }

 private:
  TinyWorld world_;
  std::unique_ptr<Localizer> localizer_ = make_scan_matching_localizer(model());
};

TEST_CASE("what the lidar is too near to see stays an obstacle, until the robot is away") {
  for (const double bias : {0.0, 0.03, -0.03}) {
    CAPTURE(bias);
    ShortSighted robot({}, {.range_sigma = 0.01, .range_bias = bias});
    robot.drive({0.3, 0.0, 0.0}, 550);
    robot.drive({0.05, 0.0, 0.0}, 500);  // slowly to 20 cm before the wall at x = 4
    CHECK(robot.pose().x > 3.75);
    CHECK(robot.nearest_obstacle() < 0.26);
    CHECK(robot.largest_gap() < 0.03);
    robot.drive({-0.3, 0.0, 0.0}, 200);
    CHECK(robot.nearest_obstacle() > 0.3);
  }
}

TEST_CASE("a wall stays where it is while the robot stands before it") {
  const TinyErrors noisy{.range_sigma = 0.015};
  ShortSighted beside({3.63, 0.0, 0.0}, noisy);
  ShortSighted close({3.4, 0.0, 0.0}, noisy);
  close.drive({0.2, 0.0, 0.0}, 90);
  REQUIRE(close.pose().x > 3.72);
  for (int i = 0; i < 60; ++i) {
    beside.drive({}, 50);
    CHECK(beside.nearest_obstacle() > 0.29);
    close.drive({}, 50);
    CHECK(close.nearest_obstacle() < 0.31);
  }
}

/// Walls 20 to 40 cm away all around, and a little more to be seen through a gap.
std::vector<TinyWall> niche() {
  std::vector<TinyWall> walls;
  add_box(walls, {-3, -2}, {4, 3});
  walls.push_back({{-0.25, -0.2}, {0.2, -0.25}});
  walls.push_back({{0.2, -0.25}, {0.3, 0.25}});
  walls.push_back({{-0.3, 0.4}, {-0.25, -0.2}});
  walls.push_back({{-0.3, 0.4}, {0.1, 0.3}});
  return walls;
}

TEST_CASE("between near walls a robot that stands does not move, however noisy its lidar is") {
  for (std::uint64_t seed = 0; seed < cases(6); ++seed) {
    CAPTURE(seed);
    TinyWorld world(niche(), {}, {.gyro_bias = 0.005, .gyro_sigma = 0.0017, .range_sigma = 0.04}, seed);
    const auto localizer = make_scan_matching_localizer(model());
    while (world.now() < 60s) {
      for (const Sample& s : world.tick({})) localizer->add(s);
    }
    const PoseEstimate e = localizer->estimate(world.now());
    CHECK_FALSE(e.lost());
    CHECK(norm(e.map_from_base().position()) < 0.005);
    CHECK(std::fabs(e.map_from_base().theta) < 0.005);
  }
}

TEST_CASE("a robot that is pushed while its wheels and gyro stand follows its scans") {
  for (std::uint64_t seed = 0; seed < cases(40); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    TinyWorld world(room(), {}, {.gyro_sigma = 0.0017, .range_sigma = 0.01}, seed);
    const auto localizer = make_scan_matching_localizer(model());
    const auto drive = [&](const Velocity& v, Duration seconds) {
      for (const Time end = world.now() + seconds; world.now() < end;) {
        for (const Sample& s : world.tick(v)) localizer->add(s);
      }
    };
    drive({0.2, 0.0, 0.3}, 3s);
    drive({}, 2s);
    const Vec2 push = draw(0.06, 0.25) * rotate({1.0, 0.0}, draw(-3.0, 3.0));
    for (TinyWall& wall : world.walls()) wall.a = wall.a - push, wall.b = wall.b - push;
    drive({}, 3s);
    const Vec2 truth = world.pose().position() + push;
    const PoseEstimate e = localizer->estimate(world.now());
    CHECK_FALSE(e.lost());
    CHECK(distance(e.map_from_base().position(), truth) < 0.045);
    drive({0.2, 0.0, -0.3}, 3s);
    CHECK(distance(localizer->estimate(world.now()).map_from_base().position(), world.pose().position() + push) < 0.04);
  }
}

}  // namespace
}  // namespace threewe::slam
