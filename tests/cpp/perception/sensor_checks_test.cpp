// Sensors that break: what each check notices and what it leaves alone.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <vector>

#include "core/exact.hpp"
#include "core/rng.hpp"
#include "draw.hpp"
#include "perception/drive_check.hpp"
#include "perception/repeat_check.hpp"
#include "perception/scan_check.hpp"
#include "perception/stamp_check.hpp"
#include "perception/turn_check.hpp"

using namespace threewe;
using namespace threewe::perception;

namespace {

// A room of random size, seen from a random place in it.
LaserScan room(std::uint64_t seed, double scatter, double bias = 0.0, double turned = 0.0, std::uint32_t lane = 1) {
  const RngKey key{.seed = seed};
  const auto draw = [&](std::uint64_t i, double low, double high) { return uniform(key, i, 0, low, high); };
  const double east = draw(0, 1.0, 6.0);
  const double west = -draw(1, 1.0, 6.0);
  const double north = draw(2, 1.0, 6.0);
  const double south = -draw(3, 1.0, 6.0);
  LaserScan scan;
  scan.angle_min = -exact::kPi;
  scan.angle_increment = 2.0 * exact::kPi / 360.0;
  scan.range_min = 0.02;
  scan.range_max = 12.0;
  for (int i = 0; i < 360; ++i) {
    const double angle = scan.angle_min + i * scan.angle_increment + turned;
    const double x = std::cos(angle);
    const double y = std::sin(angle);
    const double range = std::min(x > 0.0 ? east / x : west / x, y > 0.0 ? north / y : south / y);
    const double off = scatter * normal(key, 1000 + static_cast<std::uint64_t>(i), lane);
    scan.ranges.push_back(static_cast<float>(range + bias + off));
  }
  return scan;
}

}  // namespace

TEST_CASE("a shift of all ranges is found, whatever the turn, and nothing is where there is none") {
  for (std::uint64_t seed = 0; seed < cases(500); ++seed) {
    CAPTURE(seed);
    const RngKey key{.seed = seed};
    const double bias = (seed % 2 == 0 ? 1.0 : -1.0) * uniform(key, 10, 0, 0.1, 0.4);
    const double turned = uniform(key, 11, 0, -1.5, 1.5);
    const double misjudged = turned + uniform(key, 12, 0, -0.1, 0.1);
    const LaserScan before = room(seed, 0.01);
    const auto shifted = shift_between(before, room(seed, 0.01, bias, turned, 2), misjudged);
    CHECK(shifted.share > 0.6);
    CHECK(std::fabs(shifted.metres - bias) < 0.02);
    const auto same = shift_between(before, room(seed, 0.01, 0.0, turned, 2), misjudged);
    CHECK(std::fabs(same.metres) < 0.02);
  }
}

TEST_CASE("scans that are noisy or shifted are told from others, until they are as before") {
  for (std::uint64_t seed = 0; seed < cases(200); ++seed) {
    CAPTURE(seed);
    ScanCheck check(0.01);
    Time t{};
    const auto look = [&](double scatter, double bias) {
      t += 100ms;
      return check.check(t, room(seed, scatter, bias, 0.0, static_cast<std::uint32_t>(t / 100ms)), {});
    };
    for (int i = 0; i < 10; ++i) CHECK(look(0.01, 0.03) == SensorFault::none);
    for (int i = 0; i < 5; ++i) CHECK(look(0.05, 0.03) == SensorFault::noisy);
    for (int i = 0; i < 5; ++i) CHECK(look(0.01, 0.03) == SensorFault::none);
    for (int i = 0; i < 5; ++i) CHECK(look(0.01, 0.23) == SensorFault::shifted);
    for (int i = 0; i < 5; ++i) CHECK(look(0.01, 0.03) == SensorFault::none);
  }
}

TEST_CASE("a lidar that scatters more than its data sheet says from the first is usual; more than that is not") {
  ScanCheck check(0.01);
  Time t{};
  for (std::uint64_t i = 0; i < 20; ++i) CHECK(check.check(t += 100ms, room(i, 0.04), {}) == SensorFault::none);
  CHECK(check.check(t += 100ms, room(20, 0.16), {}) == SensorFault::noisy);
}

TEST_CASE("what is usual is not forgotten where few beams hit anything") {
  ScanCheck check(0.01);
  Time t{};
  std::uint64_t seed = 0;
  const auto look = [&](bool open) {
    LaserScan scan = room(seed++, 0.04);
    if (open) std::fill(scan.ranges.begin() + 20, scan.ranges.end(), 0.0F);
    return check.check(t += 100ms, scan, {});
  };
  for (int i = 0; i < 5; ++i) CHECK(look(true) == SensorFault::none);
  for (int i = 0; i < 20; ++i) CHECK(look(false) == SensorFault::none);
  for (int i = 0; i < 200; ++i) CHECK(look(true) == SensorFault::none);
  CHECK(look(false) == SensorFault::none);
}

TEST_CASE("stamps: backwards, from the future, too old; what is merely slow is usual") {
  StampCheck check;
  Time t{};
  const auto arrive = [&](Duration age) {
    t += 100ms;
    return check.check(t - age, t);
  };
  CHECK(arrive(90ms) == SensorFault::none);  // had waited for somebody to ask
  for (int i = 0; i < 20; ++i) CHECK(arrive(i % 2 == 0 ? 40ms : 60ms) == SensorFault::none);
  CHECK(arrive(-10ms) == SensorFault::wrong_stamps);
  CHECK(arrive(500ms) == SensorFault::wrong_stamps);  // before the newest
  CHECK(arrive(50ms) == SensorFault::none);
  for (int i = 0; i < 10; ++i) (void)arrive(600ms);
  CHECK(arrive(600ms) == SensorFault::late);
  CHECK(arrive(50ms) == SensorFault::none);
  CHECK(check.check(t, t + 100ms) == SensorFault::none);
}

TEST_CASE("repeated readings are a fault where something must have changed") {
  const Motion moving{.moving = true};
  const Motion still{.still = true};
  const LaserScan scan = room(1, 0.01);
  SUBCASE("a scan, while the robot moves") {
    RepeatCheck check;
    for (std::uint64_t i = 10; i < 16; ++i) CHECK_FALSE(check.is_frozen(room(i, 0.01), still));
    CHECK_FALSE(check.is_frozen(scan, still));
    CHECK(check.is_frozen(scan, moving));
    CHECK(check.is_frozen(scan, still));  // the robot has stopped for it
    CHECK_FALSE(check.is_frozen(room(2, 0.01), still));
  }
  SUBCASE("a scan of nothing says nothing") {
    RepeatCheck check;
    LaserScan empty = scan;
    for (float& range : empty.ranges) range = 12.0F;
    for (int i = 0; i < 20; ++i) CHECK_FALSE(check.is_frozen(empty, moving));
  }
  SUBCASE("an inertial unit, if it has noise") {
    RepeatCheck quiet;
    RepeatCheck noisy;
    for (int i = 0; i < 20; ++i) {
      CHECK_FALSE(quiet.is_frozen(IMUData{}, still));
      CHECK_FALSE(noisy.is_frozen(IMUData{{0.001 * i, 0.0, 0.0}, {}}, still));
    }
    bool frozen = false;
    for (int i = 0; i < 8; ++i) {
      CHECK_FALSE(quiet.is_frozen(IMUData{}, moving));
      frozen = noisy.is_frozen(IMUData{{0.5, 0.0, 0.0}, {}}, moving);
    }
    CHECK(frozen);
  }
  SUBCASE("an inertial unit without noise, which changes as the robot sets out, stops and turns") {
    RepeatCheck quiet;
    const auto read = [&](double rate, const Motion& motion) {
      return quiet.is_frozen(IMUData{{0.0, 0.0, rate}, {}}, motion);
    };
    for (int start = 0; start < 5; ++start) {
      for (int i = 0; i < 6; ++i) CHECK_FALSE(read(0.0, still));
      for (int i = 1; i < 4; ++i) CHECK_FALSE(read(0.01 * i, still));  // it has just stopped
      for (int i = 0; i < 20; ++i) CHECK_FALSE(read(0.0, moving));
    }
  }
  SUBCASE("an inertial unit without noise, which settles for long after each stop") {
    RepeatCheck quiet;
    const auto read = [&](double acceleration, const Motion& motion) {
      return quiet.is_frozen(IMUData{{}, {acceleration, 0.0, 0.0}}, motion);
    };
    for (int stop = 0; stop < 3; ++stop) {
      for (int i = 0; i < 40; ++i) CHECK_FALSE(read(-std::pow(3.5, -i), still));
      CHECK_FALSE(read(1.0, moving));
      for (int i = 0; i < 20; ++i) CHECK_FALSE(read(0.0, moving));
    }
  }
  SUBCASE("a camera, if it has noise") {
    const auto image = [](std::uint8_t level) {
      RGBDImage made;
      made.color.assign(12, level);
      return Picture(std::move(made));
    };
    RepeatCheck quiet;
    RepeatCheck noisy;
    for (std::uint8_t i = 0; i < 8; ++i) {
      CHECK_FALSE(quiet.is_frozen(image(7), still));
      CHECK_FALSE(noisy.is_frozen(image(i), still));
    }
    for (int i = 0; i < 8; ++i) CHECK_FALSE(quiet.is_frozen(image(7), moving));
    (void)noisy.is_frozen(image(9), moving);
    CHECK(noisy.is_frozen(image(9), moving));
  }
  SUBCASE("a lidar without noise between bare walls, which cannot tell how far along them it is") {
    LaserScan walls = room(1, 0.0);
    for (std::size_t i = 0; i < walls.ranges.size(); ++i) {
      const double angle = walls.angle_min + static_cast<double>(i) * walls.angle_increment;
      walls.ranges[i] = static_cast<float>(std::min(12.0, 1.0 / std::max(1e-9, std::fabs(std::sin(angle)))));
    }
    const Motion along{.moving = true, .velocity = {0.3, 0.0, 0.0}};
    const Motion across{.moving = true, .velocity = {0.0, 0.3, 0.0}};
    RepeatCheck check;
    for (int i = 0; i < 20; ++i) CHECK_FALSE(check.is_frozen(walls, along));
    CHECK(check.is_frozen(walls, across));
    RepeatCheck closed;
    for (int i = 0; i < 3; ++i) (void)closed.is_frozen(room(1, 0.0), along);
    CHECK(closed.is_frozen(room(1, 0.0), along));
  }
  SUBCASE("wheels that turn and get nowhere") {
    RepeatCheck check;
    for (int i = 0; i < 3; ++i) (void)check.is_frozen(Odometry{{1.0, 0.0, 0.0}, {0.2, 0.0, 0.0}}, moving);
    CHECK(check.is_frozen(Odometry{{1.0, 0.0, 0.0}, {0.2, 0.0, 0.0}}, moving));
    RepeatCheck standing;
    for (int i = 0; i < 10; ++i) CHECK_FALSE(standing.is_frozen(Odometry{{1.0, 0.0, 0.0}, {}}, moving));
    CHECK(standing.is_frozen(Odometry{{1.0, 0.0, 0.0}, {}}, {.moving = true, .driven = true}));
  }
}

TEST_CASE("gyro and wheels: systematic differences are learned, a sudden bias is noticed") {
  const RobotProfile profile = load_profile("3we_standard_v2");
  for (std::uint64_t seed = 0; seed < cases(300); ++seed) {
    CAPTURE(seed);
    const RngKey key{.seed = seed};
    TurnCheck check(profile);
    const double bias = uniform(key, 0, 0, -0.008, 0.008);
    const double per_speed = uniform(key, 0, 1, -0.03, 0.03);
    Odometry wheels;
    double worst = 0.0;
    double fault = 0.0;
    const auto drive = [&](int from, int ticks) {
      worst = 0.0;
      for (int i = from; i < from + ticks; ++i) {
        const Velocity v{0.4, 0.0, 0.8 * std::sin(0.02 * i)};
        for (int half = 1; half <= 2; ++half) {
          const double noise =
              0.0017 * normal(key, 2 * static_cast<std::uint64_t>(i) + static_cast<std::uint64_t>(half));
          check.add_gyro(20ms * i + 10ms * half, v.omega - per_speed * v.vx + bias + fault + noise);
        }
        wheels = {integrate(wheels.pose, v, 0.02), v};
        if (const auto off = check.add_odometry(20ms * (i + 1), wheels)) worst = std::max(worst, std::fabs(*off));
      }
    };
    drive(0, 1500);
    CHECK(worst < 4.0);
    fault = 0.087;
    drive(1500, 60);
    CHECK(worst > 4.0);
  }
}

TEST_CASE("an honest gyro and honest wheels of another make contradict each other nowhere") {
  struct Make {
    const char* what;
    double per_speed;  // [rad/m] by which the robot veers off straight
    double bias;       // [rad/s] of the gyro
    double noise;      // [rad/s] of the gyro
    Duration latency;  // of the gyro
    int every;         // ticks from odometry to odometry
  };
  const std::vector<Make> makes = {{"wheels worn by 3 %", 0.1, 0.0, 0.002, 0ms, 1},
                                   {"a gyro that nobody zeroed", 0.0, 0.05, 0.002, 0ms, 1},
                                   {"a noisy gyro", 0.0, 0.0, 0.03, 0ms, 1},
                                   {"a late gyro", 0.0, 0.0, 0.002, 100ms, 1},
                                   {"odometry ten times a second", 0.02, 0.01, 0.002, 0ms, 5},
                                   {"odometry five times a second", 0.02, 0.01, 0.002, 0ms, 10}};
  for (const char* robot : {"3we_standard_v2", "turtlebot_like"}) {
    for (const Make& make : makes) {
      for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        CAPTURE(robot);
        CAPTURE(make.what);
        CAPTURE(seed);
        const RngKey key{.seed = seed};
        TurnCheck check(load_profile(robot));
        Odometry wheels;
        double worst = 0.0;
        double fault = 0.0;
        bool noticed = false;
        std::deque<std::pair<Time, double>> on_the_way;
        for (int tick = 0; tick < 1100; ++tick) {
          const double phase = tick % 500 * 0.02;
          const double speed = phase < 1.0 ? 0.0 : 0.2 * std::min(1.0, 5.0 * std::min(phase - 1.0, 10.0 - phase));
          const double omega = phase > 4.0 ? 0.8 * std::sin(1.5 * (phase - 4.0)) : 0.0;
          if (tick == 1000) fault = 0.0873;
          for (int half = 1; half <= 2; ++half) {
            const auto draw = 2 * static_cast<std::uint64_t>(tick) + static_cast<std::uint64_t>(half);
            const double rate = omega - make.per_speed * speed + make.bias + fault + make.noise * normal(key, draw);
            on_the_way.emplace_back(20ms * tick + 10ms * half, rate);
          }
          const Time now = 20ms * (tick + 1);
          for (; !on_the_way.empty() && on_the_way.front().first + make.latency <= now; on_the_way.pop_front())
            check.add_gyro(on_the_way.front().first, on_the_way.front().second);
          wheels = {integrate(wheels.pose, {speed, 0.0, omega}, 0.02), {speed, 0.0, omega}};
          if (tick % make.every != 0) continue;
          const auto off = check.add_odometry(now, wheels);
          if (off && tick < 1000) worst = std::max(worst, std::fabs(*off));
          if (off && tick >= 1000) noticed = noticed || std::fabs(*off) > 4.0;
        }
        CHECK(worst < 4.0);
        CHECK(noticed);
      }
    }
  }
}

TEST_CASE("corrections along the way that are no more than what is uncertain of it say nothing of the wheels") {
  for (const double deviation : {0.01, 0.5}) {
    CAPTURE(deviation);
    WayCheck check;
    slam::PoseEstimate estimate;
    estimate.covariance[0] = deviation * deviation;
    estimate.covariance[4] = 1e-4;
    bool contradicted = false;
    for (int scan = 0; scan < 20; ++scan) {
      estimate.odom_from_base.x += 0.05;
      estimate.map_from_odom.x -= 0.025;
      contradicted = check.is_contradicted(estimate) || contradicted;
    }
    CHECK(contradicted == (deviation < 0.1));
  }
}

TEST_CASE("who has been told to drive, or to stand, for longer than it takes to obey, does so") {
  DriveCheck check(load_profile("3we_standard_v2"));
  const auto tell = [&](const Velocity& command, int periods) {
    for (int i = 0; i < periods; ++i) (void)check.is_disobeyed(command, {});
  };
  CHECK_FALSE(check.commanded_to_drive());
  tell({0.2, 0.0, 0.0}, 4);
  CHECK_FALSE(check.commanded_to_drive());
  tell({0.0, 0.0, 0.5}, 5);
  CHECK(check.commanded_to_drive());
  CHECK_FALSE(check.commanded_to_stand());
  tell({}, 1);
  CHECK_FALSE(check.commanded_to_drive());
  tell({}, 8);
  CHECK(check.commanded_to_stand());
  tell({0.2, 0.0, 0.0}, 20);
  check.begin();
  CHECK_FALSE(check.commanded_to_drive());
}

TEST_CASE("wheels that do as they are told, late, are no fault; those that do not are") {
  for (const double share : {1.0, 0.95, 0.0, 0.4}) {
    CAPTURE(share);
    DriveCheck check(load_profile("3we_standard_v2"));
    std::deque<Velocity> on_the_way(4);
    bool disobeyed = false;
    for (int i = 0; i < 500; ++i) {
      const Velocity command{0.25 + 0.25 * std::sin(0.05 * i), 0.0, 0.5 * std::cos(0.03 * i)};
      on_the_way.push_back(command);
      const Velocity done = on_the_way.front();
      on_the_way.pop_front();
      disobeyed = check.is_disobeyed(command, {share * done.vx, 0.0, share * done.omega}) || disobeyed;
    }
    CHECK(disobeyed == (share < 0.5));
  }
}

TEST_CASE("a link slower than the data sheet says is no fault, a wheel that stands still is, at any delay") {
  for (const std::size_t periods : {0u, 2u, 6u, 9u}) {
    for (const bool blocked : {false, true}) {
      CAPTURE(periods);
      CAPTURE(blocked);
      DriveCheck check(load_profile("turtlebot_like"));
      std::deque<Velocity> on_the_way(periods);
      bool disobeyed = false;
      for (int i = 0; i < 500; ++i) {  // a robot that looks for a way: to and fro at its limits
        on_the_way.push_back({0.1, 0.0, i / 40 % 2 == 0 ? 1.0 : -1.0});
        const Velocity done = blocked ? Velocity{} : on_the_way.front();
        on_the_way.pop_front();
        disobeyed = check.is_disobeyed({0.1, 0.0, i / 40 % 2 == 0 ? 1.0 : -1.0}, done) || disobeyed;
      }
      CHECK(disobeyed == blocked);
    }
  }
}

TEST_CASE("a motor at its limit is no fault, a blocked wheel of the same drive is") {
  const RobotProfile profile = load_profile("turtlebot_like");
  const double limit = 0.84 * profile.body.no_load_speed;  // by an empty battery
  for (const bool blocked : {false, true}) {
    CAPTURE(blocked);
    for (const double turn : {-1.0, -0.6, 0.6, 1.0}) {
      DriveCheck check(profile);
      const Velocity command{0.22, 0.0, turn};
      WheelSpeeds speeds = wheel_speeds(profile.body.wheels, command);
      for (double& speed : speeds) speed = std::min(speed, limit);
      if (blocked) speeds[turn > 0.0 ? 0 : 1] = 0.0;  // the slower one
      bool disobeyed = false;
      for (int i = 0; i < 100; ++i) {
        disobeyed = check.is_disobeyed(command, body_velocity(profile.body.wheels, speeds)) || disobeyed;
      }
      CHECK(disobeyed == blocked);
    }
  }
}
