#include "models/drive.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstdint>

#include "core/rng.hpp"

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

const Traction& traction() {
  static const Traction made = make_traction(robot(), 10ms);
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
    speeds = drive_motors(drive(), traction(), speeds, all(1.0), 1.0);
    time += 0.01;
    CHECK(speeds[0] == doctest::Approx(1.0 - std::exp(-time / to_seconds(robot().body.motor_lag))).epsilon(1e-12));
    CHECK(speeds[3] == speeds[0]);
  }
}

TEST_CASE("a large change of speed takes the torque that the motor has, and none at the no-load speed") {
  // from rest, stall torque accelerates a quarter of the body's mass
  const Body& body = robot().body;
  const double stall = body.stall_torque / (body.mass / 4 * body.wheels.radius * body.wheels.radius) * 0.01;
  CHECK(drive_motors(drive(), traction(), all(0.0), all(1000.0), 1.0)[0] == doctest::Approx(stall));
  CHECK(drive_motors(drive(), traction(), all(0.0), all(1000.0), 0.5)[0] == doctest::Approx(0.5 * stall));
  CHECK(drive_motors(drive(), traction(), all(body.no_load_speed / 2), all(1000.0), 1.0)[0] - body.no_load_speed / 2 ==
        doctest::Approx(0.5 * stall));

  WheelSpeeds speeds{};
  for (int i = 0; i < 1000; ++i) speeds = drive_motors(drive(), traction(), speeds, all(1000.0), 1.0);
  CHECK(speeds[0] <= body.no_load_speed);
  CHECK(speeds[0] > 0.98 * body.no_load_speed);
}

TEST_CASE("without supply the wheels only slow down") {
  const WheelSpeeds speeds = drive_motors(drive(), traction(), all(10.0), all(20.0), 0.0);
  CHECK(speeds[0] < 10.0);
  CHECK(speeds[0] > 9.0);
  CHECK(drive_motors(drive(), traction(), all(10.0), all(0.0), 0.0)[0] < 10.0);
}

TEST_CASE("two wheels of a differential base turn, the other two do not exist") {
  const RobotProfile turtle = load_profile("turtlebot_like");
  const Drive two = make_drive(turtle, 10ms);
  const WheelSpeeds speeds = drive_motors(two, make_traction(turtle, 10ms), {}, {1.0, -1.0, 5.0, 5.0}, 1.0);
  CHECK(speeds[0] > 0.0);
  CHECK(speeds[1] == -speeds[0]);
  CHECK(speeds[2] == 0.0);
  CHECK(speeds[3] == 0.0);
}

TEST_CASE("the body takes the velocity of its wheels where friction allows, and never more than friction gives") {
  const double limit = robot().body.friction * 9.80665 * 0.01;
  CHECK(limit_by_friction(drive(), traction(), {}, {0.5 * limit, 0.0, 0.0}) == Velocity{0.5 * limit, 0.0, 0.0});
  CHECK(limit_by_friction(drive(), traction(), {1.0, 0.0, 0.0}, {}).vx == doctest::Approx(1.0 - limit));
  CHECK(limit_by_friction(drive(), traction(), {0.0, -1.0, 0.0}, {}).vy == doctest::Approx(-1.0 + limit));

  for (std::uint64_t i = 0; i < 10'000; ++i) {
    CAPTURE(i);
    const Velocity body = random_velocity(2 * i);
    const Velocity rolling = random_velocity(2 * i + 1);
    const Velocity after = limit_by_friction(drive(), traction(), body, rolling);
    CHECK(std::hypot(after.vx - body.vx, after.vy - body.vy) <= limit * (1.0 + 1e-12));
    // on the way from the one to the other, not beyond
    const double share = (after.omega - body.omega) / (rolling.omega - body.omega);
    CHECK(share >= 0.0);
    CHECK(share <= 1.0 + 1e-12);
    CHECK(after.vx - body.vx == doctest::Approx(share * (rolling.vx - body.vx)));
    // wheels that stand still take energy out
    CHECK(energy(limit_by_friction(drive(), traction(), body, {})) <= energy(body));
  }
}

TEST_CASE("on a floor that holds less, friction gives less in proportion; on a hard floor the bits are the same") {
  for (std::uint64_t i = 0; i < 1'000; ++i) {
    CAPTURE(i);
    const Velocity body = random_velocity(2 * i);
    const Velocity rolling = random_velocity(2 * i + 1);
    Traction slippery = traction();
    slippery.friction_change *= 0.3;
    CHECK(limit_by_friction(drive(), traction(), body, rolling, 0.3) ==
          limit_by_friction(drive(), slippery, body, rolling));
    CHECK(limit_by_friction(drive(), traction(), body, rolling, 1.0) ==
          limit_by_friction(drive(), traction(), body, rolling));
  }
}

TEST_CASE("power is that of the acceleration, and of rolling") {
  const double rolling = robot().body.rolling_resistance * robot().body.mass * 9.80665;
  CHECK(drive_power(drive(), traction(), {0.5, 0.0, 0.0}, {0.5, 0.0, 0.0}, {0.5, 0.0, 0.0}) ==
        doctest::Approx(0.5 * rolling));
  CHECK(drive_power(drive(), traction(), {0.49, 0.0, 0.0}, {0.5, 0.0, 0.0}, {0.5, 0.0, 0.0}) ==
        doctest::Approx(0.5 * rolling + 2.5 * 1.0 * 0.5));
  CHECK(drive_power(drive(), traction(), {}, {}, {}) == 0.0);
  CHECK(drive_power(drive(), traction(), {0.0, 0.0, 1.0}, {0.0, 0.0, 0.5}, {0.0, 0.0, 0.5}) < 0.0);
  // the same force at wheels that spin twice as fast
  CHECK(drive_power(drive(), traction(), {0.49, 0.0, 0.0}, {0.5, 0.0, 0.0}, {1.0, 0.0, 0.0}) ==
        doctest::Approx(1.0 * rolling + 2.5 * 1.0 * 1.0));
}

TEST_CASE("motors give their torque exactly, or with noise: normal, its own at each wheel and step") {
  const RngKey key{.seed = 4, .stream = Stream::motor};
  CHECK(motor_shares(traction(), key, 7) == std::array{1.0, 1.0, 1.0, 1.0});

  const Traction noisy = make_traction(robot(), 10ms, {.motor_noise = 0.1});
  constexpr std::uint64_t kSteps = 50'000;
  std::array<double, 4> sum{};
  std::array<double, 4> square{};
  double product = 0.0;
  double before = 0.0;
  double within_one_sigma = 0.0;
  for (std::uint64_t step = 0; step < kSteps; ++step) {
    const std::array<double, 4> shares = motor_shares(noisy, key, step);
    for (std::size_t i = 0; i < 4; ++i) {
      const double off = shares[i] - 1.0;
      sum[i] += off;
      square[i] += off * off;
      if (std::fabs(off) < 0.1) within_one_sigma += 0.25;
    }
    product += (shares[0] - 1.0) * (shares[1] - 1.0) + (shares[0] - 1.0) * before;
    before = shares[0] - 1.0;
  }
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(sum[i] / kSteps == doctest::Approx(0.0).scale(1.0).epsilon(0.002));
    CHECK(std::sqrt(square[i] / kSteps) == doctest::Approx(0.1).epsilon(0.02));
  }
  CHECK(within_one_sigma / kSteps == doctest::Approx(0.6827).epsilon(0.01));
  CHECK(product / kSteps / 0.01 == doctest::Approx(0.0).scale(1.0).epsilon(0.02));
  CHECK(motor_shares(noisy, key, 7) == motor_shares(noisy, key, 7));
}

TEST_CASE("a motor's share scales the change that it makes, whatever limits it") {
  for (const double target : {1.0, 1000.0}) {
    const double whole = drive_motors(drive(), traction(), all(0.0), all(target), 1.0)[1];
    const WheelSpeeds shared = drive_motors(drive(), traction(), all(0.0), all(target), 1.0, {1.0, 0.9, 1.0, 1.2});
    CHECK(shared[0] == whole);
    CHECK(shared[1] == doctest::Approx(0.9 * whole));
    CHECK(shared[3] == doctest::Approx(1.2 * whole));
  }
}
