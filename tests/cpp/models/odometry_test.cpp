#include "models/odometry.hpp"

#include <doctest/doctest.h>

#include <cmath>

#include "draw.hpp"

using namespace threewe;
using namespace threewe::models;

namespace {

const RobotProfile& robot() {
  static const RobotProfile profile = load_profile("3we_standard_v2");
  return profile;
}

const WheelGeometry& wheels() { return robot().body.wheels; }

// Rolls without slip at a constant body velocity and returns the last reading.
Odometry roll(const OdometrySpec& spec, const WheelErrors& errors, const Velocity& velocity, double seconds) {
  const WheelSpeeds speeds = wheel_speeds(wheels(), velocity);
  const double period = to_seconds(spec.period);
  const int samples = static_cast<int>(std::lround(seconds / period));
  OdometryState state;
  for (int i = 1; i <= samples; ++i) {
    std::array<double, 4> angles{};
    for (std::size_t wheel = 0; wheel < 4; ++wheel) angles[wheel] = speeds[wheel] * period * i;
    measure_odometry(make_odometer(spec, wheels()), errors, angles, state);
  }
  return state.reading;
}

}  // namespace

TEST_CASE("a perfect odometer follows the arc that the wheels roll") {
  const OdometrySpec perfect{.period = 20ms};
  for (const Velocity& velocity : {Velocity{0.5, 0.0, 0.0}, {0.0, 0.3, 0.0}, {0.0, 0.0, 1.0}, {0.4, -0.2, 0.7}}) {
    const Odometry reading = roll(perfect, {}, velocity, 2.0);
    const Pose2D expected = integrate({}, velocity, 2.0);
    CHECK(reading.pose.x == doctest::Approx(expected.x).epsilon(1e-9).scale(1.0));
    CHECK(reading.pose.y == doctest::Approx(expected.y).epsilon(1e-9).scale(1.0));
    CHECK(reading.pose.theta == doctest::Approx(expected.theta).epsilon(1e-9).scale(1.0));
    CHECK(reading.velocity.vx == doctest::Approx(velocity.vx).epsilon(1e-9).scale(1.0));
    CHECK(reading.velocity.vy == doctest::Approx(velocity.vy).epsilon(1e-9).scale(1.0));
    CHECK(reading.velocity.omega == doctest::Approx(velocity.omega).epsilon(1e-9).scale(1.0));
  }
}

TEST_CASE("an encoder shows whole counts: never off by more than one, and the error does not grow") {
  OdometrySpec spec{.period = 20ms};
  spec.ticks_per_turn = robot().odometry.ticks_per_turn;
  const double tick = 2.0 * M_PI / spec.ticks_per_turn * wheels().radius;
  for (const double seconds : {0.1, 1.0, 10.0, 100.0}) {
    const Odometry reading = roll(spec, {}, {0.1, 0.0, 0.0}, seconds);
    CHECK(std::fabs(reading.pose.x - 0.1 * seconds) <= tick);
  }
}

TEST_CASE("wheels that are off by 1 % bend and stretch the path by as much") {
  const OdometrySpec perfect{.period = 20ms};
  WheelErrors larger;
  larger.scale = {1.01, 1.01, 1.01, 1.01};
  CHECK(roll(perfect, larger, {0.5, 0.0, 0.0}, 2.0).pose.x == doctest::Approx(1.01));

  WheelErrors right;
  right.scale = {1.0, 1.01, 1.0, 1.01};
  const Odometry bent = roll(perfect, right, {0.5, 0.0, 0.0}, 2.0);
  const double arm = wheels().half_length + wheels().half_width;
  CHECK(bent.pose.theta == doctest::Approx(0.5 * 0.01 * 1.0 / arm));
}

TEST_CASE("wheel errors are drawn once per episode, within their bounds") {
  const OdometrySpec& spec = robot().odometry;
  double lowest = 1.0;
  double highest = 0.0;
  for (std::uint64_t seed = 0; seed < cases(2000); ++seed) {
    const RngKey key{.seed = seed, .stream = Stream::odometry};
    const WheelErrors errors = draw_wheel_errors(spec, key);
    for (const double scale : errors.scale) CHECK(std::fabs(scale - 1.0) <= 0.015);
    CHECK(errors.scale[0] != errors.scale[1]);
    lowest = std::min(lowest, errors.lateral);
    highest = std::max(highest, errors.lateral);
    CHECK(draw_wheel_errors(spec, key).scale == errors.scale);
    RngKey other = key;
    other.episode = 1;
    CHECK(draw_wheel_errors(spec, other).scale != errors.scale);
  }
  CHECK(lowest == doctest::Approx(0.85).epsilon(0.001));
  CHECK(highest == doctest::Approx(0.98).epsilon(0.001));
}

TEST_CASE("slip stretches how far the wheels are from nominal, and one changes no bit") {
  const OdometrySpec& spec = robot().odometry;
  for (std::uint64_t seed = 0; seed < cases(500); ++seed) {
    CAPTURE(seed);
    const RngKey key{.seed = seed, .stream = Stream::odometry};
    const WheelErrors drawn = draw_wheel_errors(spec, key);
    const WheelErrors same = draw_wheel_errors(spec, key, 1.0);
    const WheelErrors none = draw_wheel_errors(spec, key, 0.0);
    const WheelErrors twice = draw_wheel_errors(spec, key, 2.0);
    CHECK((same.scale == drawn.scale && same.lateral == drawn.lateral));
    CHECK(none.lateral == doctest::Approx(1.0));
    CHECK(twice.lateral - 1.0 == doctest::Approx(2.0 * (drawn.lateral - 1.0)));
    for (std::size_t wheel = 0; wheel < 4; ++wheel) {
      CHECK(none.scale[wheel] == doctest::Approx(1.0));
      CHECK(twice.scale[wheel] - 1.0 == doctest::Approx(2.0 * (drawn.scale[wheel] - 1.0)));
    }
  }
}
