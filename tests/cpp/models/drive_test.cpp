#include "threewe/models/drive.hpp"

#include <doctest/doctest.h>

#include <cmath>

#include "threewe/core/rng.hpp"

using namespace threewe;
using namespace threewe::models;

namespace {

const RobotProfile& robot() {
  static const RobotProfile profile = load_profile("3we_standard_v2");
  return profile;
}

const Drive& drive() {
  static const Drive made = make_drive(robot(), 10ms);
  return made;
}

WheelSpeeds all(double speed) { return {speed, speed, speed, speed}; }

Velocity random_velocity(std::uint64_t i) {
  const RngKey key{.seed = 1};
  return {uniform(key, i, 0, -2.0, 2.0), uniform(key, i, 1, -2.0, 2.0), uniform(key, i, 2, -6.0, 6.0)};
}

double energy(const Velocity& v) {
  return robot().body.mass * (v.vx * v.vx + v.vy * v.vy) + robot().body.inertia * v.omega * v.omega;
}

}  // namespace

TEST_CASE("motors approach a small change of speed exponentially with their time constant") {
  WheelSpeeds speeds{};
  double time = 0.0;
  for (int i = 0; i < 20; ++i) {
    speeds = drive_motors(drive(), speeds, all(1.0), 1.0);
    time += 0.01;
    CHECK(speeds[0] == doctest::Approx(1.0 - std::exp(-time / to_seconds(robot().body.motor_lag))).epsilon(1e-12));
    CHECK(speeds[3] == speeds[0]);
  }
}

TEST_CASE("a large change of speed takes the torque that the motor has, and none at the no-load speed") {
  // from rest, stall torque accelerates a quarter of the body's mass
  const Body& body = robot().body;
  const double stall = body.stall_torque / (body.mass / 4 * body.wheels.radius * body.wheels.radius) * 0.01;
  CHECK(drive_motors(drive(), all(0.0), all(1000.0), 1.0)[0] == doctest::Approx(stall));
  CHECK(drive_motors(drive(), all(0.0), all(1000.0), 0.5)[0] == doctest::Approx(0.5 * stall));
  CHECK(drive_motors(drive(), all(body.no_load_speed / 2), all(1000.0), 1.0)[0] - body.no_load_speed / 2 ==
        doctest::Approx(0.5 * stall));

  WheelSpeeds speeds{};
  for (int i = 0; i < 1000; ++i) speeds = drive_motors(drive(), speeds, all(1000.0), 1.0);
  CHECK(speeds[0] <= body.no_load_speed);
  CHECK(speeds[0] > 0.98 * body.no_load_speed);
}

TEST_CASE("without supply the wheels only slow down") {
  const WheelSpeeds speeds = drive_motors(drive(), all(10.0), all(20.0), 0.0);
  CHECK(speeds[0] < 10.0);
  CHECK(speeds[0] > 9.0);
  CHECK(drive_motors(drive(), all(10.0), all(0.0), 0.0)[0] < 10.0);
}

TEST_CASE("two wheels of a differential base turn, the other two do not exist") {
  const Drive two = make_drive(load_profile("turtlebot_like"), 10ms);
  const WheelSpeeds speeds = drive_motors(two, {}, {1.0, -1.0, 5.0, 5.0}, 1.0);
  CHECK(speeds[0] > 0.0);
  CHECK(speeds[1] == -speeds[0]);
  CHECK(speeds[2] == 0.0);
  CHECK(speeds[3] == 0.0);
}

TEST_CASE("the body takes the velocity of its wheels where friction allows, and never more than friction gives") {
  const double limit = robot().body.friction * 9.80665 * 0.01;
  CHECK(grip(drive(), {}, {0.5 * limit, 0.0, 0.0}) == Velocity{0.5 * limit, 0.0, 0.0});
  CHECK(grip(drive(), {1.0, 0.0, 0.0}, {}).vx == doctest::Approx(1.0 - limit));
  CHECK(grip(drive(), {0.0, -1.0, 0.0}, {}).vy == doctest::Approx(-1.0 + limit));

  for (std::uint64_t i = 0; i < 10'000; ++i) {
    CAPTURE(i);
    const Velocity body = random_velocity(2 * i);
    const Velocity rolling = random_velocity(2 * i + 1);
    const Velocity after = grip(drive(), body, rolling);
    CHECK(std::hypot(after.vx - body.vx, after.vy - body.vy) <= limit * (1.0 + 1e-12));
    // on the way from the one to the other, not beyond
    const double share = (after.omega - body.omega) / (rolling.omega - body.omega);
    CHECK(share >= 0.0);
    CHECK(share <= 1.0 + 1e-12);
    CHECK(after.vx - body.vx == doctest::Approx(share * (rolling.vx - body.vx)));
    // wheels that stand still take energy out
    CHECK(energy(grip(drive(), body, {})) <= energy(body));
  }
}

TEST_CASE("on a floor that holds less, friction gives less in proportion; on a hard floor the bits are the same") {
  for (std::uint64_t i = 0; i < 1'000; ++i) {
    CAPTURE(i);
    const Velocity body = random_velocity(2 * i);
    const Velocity rolling = random_velocity(2 * i + 1);
    Drive slippery = drive();
    slippery.grip_change *= 0.3;
    CHECK(grip(drive(), body, rolling, 0.3) == grip(slippery, body, rolling));
    CHECK(grip(drive(), body, rolling, 1.0) == grip(drive(), body, rolling));
  }
}

TEST_CASE("power is that of the acceleration, and of rolling") {
  const double rolling = robot().body.rolling_resistance * robot().body.mass * 9.80665;
  CHECK(drive_power(drive(), {0.5, 0.0, 0.0}, {0.5, 0.0, 0.0}, {0.5, 0.0, 0.0}) == doctest::Approx(0.5 * rolling));
  CHECK(drive_power(drive(), {0.49, 0.0, 0.0}, {0.5, 0.0, 0.0}, {0.5, 0.0, 0.0}) ==
        doctest::Approx(0.5 * rolling + 2.5 * 1.0 * 0.5));
  CHECK(drive_power(drive(), {}, {}, {}) == 0.0);
  CHECK(drive_power(drive(), {0.0, 0.0, 1.0}, {0.0, 0.0, 0.5}, {0.0, 0.0, 0.5}) < 0.0);
  // the same force at wheels that spin twice as fast
  CHECK(drive_power(drive(), {0.49, 0.0, 0.0}, {0.5, 0.0, 0.0}, {1.0, 0.0, 0.0}) ==
        doctest::Approx(1.0 * rolling + 2.5 * 1.0 * 1.0));
}
