// Wheels that spin freely: beside a slow twin that takes them one by one, and what such a drive must do.
#include "models/traction.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <utility>

#include "core/rng.hpp"
#include "draw.hpp"

namespace threewe::models {
namespace {

constexpr Duration kStep = 10ms;

// Of wheels that spin freely: where the body is pulled to, and how fast they are then.
std::pair<Velocity, WheelSpeeds> apply_traction(const RobotProfile& profile, const Traction& traction, double floor,
                                                double lateral, double supply, const std::array<double, 4>& shares,
                                                const Velocity& command, const Velocity& body) {
  const TractionSpec& spec = *profile.body.traction;
  const WheelGeometry& geometry = profile.body.wheels;
  const bool mecanum = geometry.kinematics == Kinematics::holonomic;
  const int count = geometry.wheel_count();
  const double arm = geometry.half_length + geometry.half_width;
  const double inertia = profile.body.inertia / (profile.body.mass * arm * arm);
  constexpr std::array<int, 4> kAcross = {-1, 1, 1, -1};
  constexpr std::array<int, 4> kAround = {-1, 1, -1, 1};
  constexpr std::array<int, 4> kFront = {1, 1, -1, -1};
  constexpr std::array<int, 4> kLeft = {1, -1, 1, -1};
  constexpr std::array<int, 4> kPair = {1, -1, -1, 1};
  const auto at = [&](int i, double x, double y, double turn) {
    const auto wheel = static_cast<std::size_t>(i);
    return x + (mecanum ? kAcross[wheel] * y : 0.0) + kAround[wheel] * turn;
  };

  const double ex = spec.ahead * command.vx - body.vx;
  const double ey = spec.sideways * lateral * command.vy - body.vy;
  const double et = arm * (spec.turning * command.omega - body.omega);
  std::array<double, 4> wanted{};
  double shifted = 0.0;
  const double stall = traction.stall_change * geometry.radius;
  for (int i = 0; i < count; ++i) {
    const auto wheel = static_cast<std::size_t>(i);
    const double line = 1.0 + traction.stall_change / profile.body.no_load_speed;
    const double speed = at(i, body.vx, body.vy, arm * body.omega) / geometry.radius / profile.body.no_load_speed;
    const double most = stall * std::clamp((supply - speed) / line, -1.0, 1.0);
    const double least = -stall * std::clamp((supply + speed) / line, -1.0, 1.0);
    const double push = at(i, traction.response * ex, traction.response * ey, traction.turn_response * inertia * et);
    wanted[wheel] = shares[wheel] * std::clamp(push, least, most);
    const double fast = spec.shift > 0.0 ? std::min(std::abs(at(i, ex, ey, et)) / spec.shift_speed, 1.0) : 0.0;
    shifted += 0.5 * spec.shift * kPair[wheel] * fast;
  }

  Velocity gained;
  std::array<double, 4> pushes{};
  for (int pass = 0; pass < 2; ++pass) {
    Velocity next;
    for (int i = 0; i < count; ++i) {
      const auto wheel = static_cast<std::size_t>(i);
      const double per_gain = spec.mass_height / (9.80665 * 0.01);
      double load = spec.load;
      if (mecanum) {
        load -= kFront[wheel] * per_gain / geometry.half_length * gained.vx +
                kLeft[wheel] * per_gain / geometry.half_width * gained.vy - kPair[wheel] * shifted;
      } else {
        load -= per_gain / 0.081 * gained.vx;  // the turtle's caster
      }
      const double holds =
          floor * traction.friction_change * std::clamp(load, 0.0, 2.0) / (mecanum ? std::numbers::sqrt2 : 1.0);
      pushes[wheel] = std::clamp(wanted[wheel], -holds, holds);
      next.vx += pushes[wheel] / count;
      next.vy += mecanum ? kAcross[wheel] * pushes[wheel] / count : 0.0;
      next.omega += kAround[wheel] * pushes[wheel] / count / (inertia * arm);
    }
    gained = next;
  }
  if (!mecanum) {
    const double held = floor * traction.friction_change * spec.load;
    gained.vy = std::clamp(-body.vy, -held, held);
  }
  const Velocity after{body.vx + gained.vx, body.vy + gained.vy, body.omega + gained.omega};
  WheelSpeeds wheels{};
  for (int i = 0; i < count; ++i) {
    const auto wheel = static_cast<std::size_t>(i);
    const bool slips = pushes[wheel] != wanted[wheel];
    const double rolls =
        slips ? at(i, command.vx, command.vy, arm * command.omega) - pushes[wheel] / traction.response
              : at(i, after.vx / spec.ahead, after.vy / (spec.sideways * lateral), arm * after.omega / spec.turning);
    wheels[wheel] = rolls / geometry.radius;
  }
  return {after, wheels};
}

bool near(double a, double b) { return std::abs(a - b) <= 1e-9 * (1.0 + std::abs(a)); }

RobotProfile random_robot(const RngKey& key) {
  std::uint32_t lane = 0;
  const auto draw = [&](double low, double high) { return uniform(key, 0, lane++, low, high); };
  RobotProfile profile = load_profile(draw(0.0, 1.0) < 0.5 ? "3we_standard_v2" : "turtlebot_like");
  const bool mecanum = profile.kinematics() == Kinematics::holonomic;
  profile.body.friction = draw(0.05, 1.0);
  profile.body.motor_lag = from_seconds(draw(0.005, 0.1));
  TractionSpec traction;
  traction.ahead = draw(0.9, 1.1);
  traction.turning = draw(0.9, 1.1);
  traction.turning_lag = from_seconds(draw(0.002, 0.1));
  traction.load = mecanum ? 1.0 : draw(0.3, 1.0);
  traction.mass_height = draw(0.0, 0.15);
  if (mecanum) {
    traction.sideways = draw(0.9, 1.1);
    traction.shift = draw(0.0, 0.8);
    traction.shift_speed = draw(0.05, 1.0);
  }
  profile.body.traction = traction;
  return profile;
}

TEST_CASE("all wheels at once do what each would alone") {
  std::size_t slipping = 0;
  for (std::uint64_t seed = 0; seed < cases(20'000); ++seed) {
    CAPTURE(seed);
    const RngKey key{.seed = seed};
    const RobotProfile profile = random_robot(key);
    const bool mecanum = profile.kinematics() == Kinematics::holonomic;
    const auto draw = [&](std::uint32_t lane, double most) { return uniform(key, 1, lane, -most, most); };
    const Velocity body{draw(0, 0.5), draw(1, mecanum ? 0.5 : 0.05), draw(2, 3.0)};
    const Velocity command{draw(3, 0.5), mecanum ? draw(4, 0.5) : 0.0, draw(5, 3.0)};
    const double floor = uniform(key, 2) < 0.2 ? 0.1 : 1.0;
    const double supply = uniform(key, 3, 0, 0.0, 1.2);
    const std::array<double, 4> shares = {1.0, 0.9, 1.1, 1.0};
    const Drive drive = make_drive(profile, kStep);
    const Traction traction = make_traction(profile, kStep);

    const TractionStep pulled = apply_traction(drive, make_traction_model(profile, kStep), traction, body, command,
                                               0.95, supply, floor, shares);
    const auto [expected, wheels] = apply_traction(profile, traction, floor, 0.95, supply, shares, command, body);
    CHECK(near(pulled.body.vx, expected.vx));
    CHECK(near(pulled.body.vy, expected.vy));
    CHECK(near(pulled.body.omega, expected.omega));
    for (std::size_t i = 0; i < 4; ++i) CHECK(near(pulled.wheels[i], wheels[i]));
    if (std::abs(pulled.body.vx - body.vx) < 0.5 * traction.response * std::abs(command.vx - body.vx)) ++slipping;
  }
  CHECK(slipping > cases(1'000));
}

// The profile with a traction that loses nothing.
RobotProfile lossless(const char* name, double friction) {
  RobotProfile profile = load_profile(name);
  profile.body.friction = friction;
  profile.body.traction = TractionSpec{};
  profile.body.traction->turning_lag = profile.body.motor_lag;
  return profile;
}

Velocity after_steps(const RobotProfile& profile, const Velocity& command, int steps) {
  Velocity body;
  for (int i = 0; i < steps; ++i) {
    body = apply_traction(make_drive(profile, kStep), make_traction_model(profile, kStep),
                          make_traction(profile, kStep), body, command)
               .body;
  }
  return body;
}

TEST_CASE("on a floor that holds, the body follows with the motors' lag") {
  const RobotProfile profile = lossless("3we_standard_v2", 100.0);
  const Velocity body = after_steps(profile, {0.02, 0.01, 0.03}, 3);  // so small that no motor is at its limit
  const double share = 1.0 - std::exp(-1.0);                          // 30 ms are the lag
  CHECK(body.vx == doctest::Approx(0.02 * share));
  CHECK(body.vy == doctest::Approx(0.01 * share));
  CHECK(body.omega == doctest::Approx(0.03 * share));
}

TEST_CASE("a mecanum wheel that slips pushes with its friction, along its roller") {
  const RobotProfile profile = lossless("3we_standard_v2", 0.2);
  const double pushed = 0.2 * kGravity * 0.01;  // of the whole weight, in a step
  CHECK(after_steps(profile, {0.5, 0.0, 0.0}, 1).vx == doctest::Approx(pushed / std::numbers::sqrt2));
  // straight along a diagonal two wheels push, and two roll
  const Velocity diagonal = after_steps(profile, {0.4, 0.4, 0.0}, 1);
  CHECK(diagonal.vx == doctest::Approx(0.5 * pushed / std::numbers::sqrt2));
  CHECK(diagonal.vy == doctest::Approx(diagonal.vx));
}

TEST_CASE("a motor at its line comes to rest on it") {
  RobotProfile profile = lossless("turtlebot_like", 0.8);
  const double fastest = profile.body.no_load_speed * profile.body.wheels.radius;
  CHECK(after_steps(profile, {2.0 * fastest, 0.0, 0.0}, 200).vx == doctest::Approx(fastest));
}

}  // namespace
}  // namespace threewe::models
