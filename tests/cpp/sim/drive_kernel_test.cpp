// The vectorised drive beside its plain twin: thousands of random robots, the same bits, on every target.
#include "sim/drive_kernel.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "core/rng.hpp"
#include "core/targets.hpp"
#include "draw.hpp"
#include "sim/step.hpp"

using namespace threewe;
using namespace threewe::sim;

namespace {

// The formulae of a step as one would write them for one robot.
namespace plain {

Velocity within_limits(const models::Drive& drive, Velocity v) {
  const double speed = std::sqrt(v.vx * v.vx + v.vy * v.vy);
  if (speed > drive.linear_limit * (1.0 + 1e-12)) {
    const double share = drive.linear_limit / speed;
    v.vx *= share;
    v.vy *= share;
  }
  v.omega = std::clamp(v.omega, -drive.angular_limit, drive.angular_limit);
  return v;
}

WheelSpeeds setpoints(const models::Drive& drive, const Velocity& v) {
  const double turn = drive.turn_arm * v.omega;
  if (drive.sideways == 0.0) {
    return {(v.vx - turn) * drive.turns_per_metre, (v.vx + turn) * drive.turns_per_metre, 0.0, 0.0};
  }
  return {(v.vx - v.vy - turn) * drive.turns_per_metre, (v.vx + v.vy + turn) * drive.turns_per_metre,
          (v.vx + v.vy - turn) * drive.turns_per_metre, (v.vx - v.vy + turn) * drive.turns_per_metre};
}

double turn_motor(const models::Drive& drive, const models::Traction& traction, double speed, double setpoint,
                  double supply, double share) {
  const double ratio = speed * drive.per_no_load_speed;
  const double forwards = traction.stall_change * std::clamp(supply - ratio, -1.0, 1.0);
  const double backwards = traction.stall_change * std::clamp(supply + ratio, -1.0, 1.0);
  return speed + share * std::clamp(traction.response * (setpoint - speed), -backwards, forwards);
}

Velocity rolling_velocity(const models::Drive& drive, const WheelSpeeds& w) {
  if (drive.sideways == 0.0) return {drive.roll * (w[0] + w[1]), 0.0, drive.roll_turn * (w[1] - w[0])};
  return {drive.roll * ((w[0] + w[2]) + (w[1] + w[3])), drive.roll * ((w[1] + w[2]) - (w[0] + w[3])),
          drive.roll_turn * ((w[1] + w[3]) - (w[0] + w[2]))};
}

Velocity limit_by_friction(const models::Drive& drive, double given, const Velocity& body, const Velocity& rolling) {
  const Velocity change{rolling.vx - body.vx, rolling.vy - body.vy, rolling.omega - body.omega};
  const double turning = change.omega * drive.turn_weight;
  const double needed = std::sqrt(change.vx * change.vx + change.vy * change.vy + turning * turning);
  if (needed <= given) return rolling;
  const double share = given / needed;
  return {body.vx + share * change.vx, body.vy + share * change.vy, body.omega + share * change.omega};
}

double power(const models::Drive& drive, double mass, const Velocity& before, const Velocity& after,
             const Velocity& rolling) {
  const double accelerating = (after.vx - before.vx) * rolling.vx + (after.vy - before.vy) * rolling.vy +
                              drive.inertia_arm_squared * (after.omega - before.omega) * rolling.omega;
  const double resisting = drive.resistance * std::sqrt(rolling.vx * rolling.vx + rolling.vy * rolling.vy);
  return mass * (accelerating * drive.per_step + resisting);
}

double supply(const models::Battery& battery, const BatteryState& state) {
  if (battery.present == 0.0) return 1.0;
  return state.charge <= 0.0 ? 0.0 : state.voltage * battery.per_nominal;
}

BatteryState drain(const models::Battery& battery, double resistance, double drive_power, BatteryState state) {
  if (battery.present == 0.0) return state;
  const double power = battery.idle_power + std::max(drive_power, 0.0) * battery.per_efficiency;
  const double open_circuit = battery.voltage_empty + battery.voltage_span * state.charge;
  state.current = power / state.voltage;
  if (state.current * resistance > 0.5 * open_circuit) state.current = 0.5 * open_circuit / resistance;
  state.voltage = open_circuit - state.current * resistance;
  state.charge = std::max(state.charge - open_circuit * state.current * 0.01 * battery.per_capacity, 0.0);
  return state;
}

// Changes the state, as the kernel does, and tells where its body would go.
kernel::Driven drive(const kernel::Driver& driver) {
  const RobotModel& robot = *driver.robot;
  RobotState& state = *driver.state;
  const WheelSpeeds wanted = setpoints(robot.drive, within_limits(robot.drive, *driver.command));
  const double supplied = supply(robot.battery, state.battery);
  const auto shares = models::motor_shares(state.traction, state.key(Stream::motor), state.steps);
  for (std::size_t i = 0; i < (robot.drive.sideways == 0.0 ? 2 : 4); ++i) {
    state.wheel_speeds[i] =
        turn_motor(robot.drive, state.traction, state.wheel_speeds[i], wanted[i], supplied, shares[i]);
  }
  const Vec2 linear = rotate({state.velocity.vx, state.velocity.vy}, -0.01 * state.velocity.omega);
  const Velocity carried{linear.x, linear.y, state.velocity.omega};
  Velocity rolling = rolling_velocity(robot.drive, state.wheel_speeds);
  rolling.vy *= state.wheel_errors.lateral;
  Velocity after = limit_by_friction(robot.drive, driver.floor * state.traction.friction_change, carried, rolling);
  if (robot.profile.body.traction) {
    // the formula for one robot, which has a twin of its own in the tests of the models
    const auto [body, wheels] = models::apply_traction(robot.drive, robot.traction_model, state.traction, carried,
                                                       within_limits(robot.drive, *driver.command),
                                                       state.wheel_errors.lateral, supplied, driver.floor, shares);
    after = body;
    state.wheel_speeds = wheels;
    rolling = rolling_velocity(robot.drive, wheels);
  }
  for (std::size_t i = 0; i < 4; ++i) state.wheel_angles[i] += 0.01 * state.wheel_speeds[i];
  state.battery = drain(robot.battery, state.battery_resistance,
                        power(robot.drive, state.traction.mass, carried, after, rolling), state.battery);
  const Pose2D end = integrate(state.pose, after, 0.01);
  const double way = distance(state.pose.position(), end.position());
  return {end.x,
          end.y,
          end.theta,
          after.vx,
          after.vy,
          after.omega,
          state.max_collision_speed,
          state.distance_driven + way,
          carried.vx,
          carried.vy,
          carried.omega,
          state.wheel_errors.lateral};
}

void measure_odometry(const models::Odometer& odometer, RobotState& state) {
  WheelSpeeds rolled{};
  for (std::size_t i = 0; i < 4; ++i) {
    double angle = state.wheel_angles[i];
    if (odometer.count != 0.0) angle = odometer.count * std::floor(angle * odometer.counts_per_radian);
    rolled[i] = state.wheel_errors.scale[i] * (angle - state.odometry.read[i]);
    state.odometry.read[i] = angle;
  }
  Velocity moved{odometer.roll * ((rolled[0] + rolled[2]) + (rolled[1] + rolled[3])), 0.0,
                 odometer.roll_turn * ((rolled[1] + rolled[3]) - (rolled[0] + rolled[2]))};
  if (odometer.sideways != 0.0) moved.vy = odometer.roll * ((rolled[1] + rolled[2]) - (rolled[0] + rolled[3]));
  const double per_period = odometer.per_period;
  state.odometry.reading = {integrate(state.odometry.reading.pose, moved, 1.0),
                            {moved.vx * per_period, moved.vy * per_period, moved.omega * per_period}};
}

}  // namespace plain

std::vector<std::shared_ptr<const Model>> models_of_all_kinds() {
  scene::Scene hall;
  hall.name = "hall";
  hall.min = {-5.0, -5.0};
  hall.max = {5.0, 5.0};
  hall.starts = {{}};
  const auto scene = std::make_shared<const scene::Scene>(hall);
  RobotProfile standard = load_profile("3we_standard_v2");
  RobotProfile turtle = load_profile("turtlebot_like");
  RobotProfile endless = standard;
  endless.battery.reset();
  endless.odometry.ticks_per_turn = 0;
  RobotProfile icy = standard;
  icy.body.friction = 0.05;
  std::vector<std::shared_ptr<const Model>> all;
  RobotProfile light = standard;
  light.body.traction = {.ahead = 0.99,
                         .sideways = 0.97,
                         .turning = 0.98,
                         .turning_lag = 8ms,
                         .load = 1.0,
                         .mass_height = 0.08,
                         .shift = 0.5,
                         .shift_speed = 0.6};
  RobotProfile light_turtle = turtle;
  light_turtle.body.traction = {.turning_lag = 30ms, .load = 0.6, .mass_height = 0.05};
  for (RobotProfile* profile : {&standard, &turtle, &endless, &icy, &light, &light_turtle}) {
    profile->lidar.reset();
    profile->ultrasonics.reset();
    all.push_back(make_model(scene, {*profile}));
  }
  return all;
}

RobotState random_state(const Model& model, const RngKey& key, std::uint64_t i) {
  std::uint32_t lane = 0;
  const auto draw = [&](double low, double high) { return uniform(key, i, lane++, low, high); };
  const auto seldom = [&] { return draw(0.0, 1.0) < 0.15; };
  models::Variation variation{.mass = draw(0.8, 1.2),
                              .friction = draw(0.5, 1.5),
                              .motor_lag = draw(0.5, 2.0),
                              .motor_noise = seldom() ? 0.1 : 0.0,
                              .battery_charge = draw(0.0, 1.0),
                              .battery_resistance = seldom() ? 60.0 : draw(0.0, 3.0),
                              .odometry_slip = draw(0.0, 2.0)};
  if (seldom()) variation.battery_charge = 0.0;
  const Pose2D pose{draw(-50.0, 50.0), draw(-50.0, 50.0), seldom() ? 3.14159 : draw(-M_PI, M_PI)};
  RobotState state = begin(model, 0, pose, i, 3, variation);
  state.steps = i;
  // some stand, some roll without slip, some slip, some spin faster than any motor does
  if (!seldom()) {
    const double speed = seldom() ? 2.0 : 0.5;
    const double turn = seldom() ? 100.0 : seldom() ? 1e-3 : 3.0;
    state.velocity = {draw(-speed, speed), draw(-speed, speed), draw(-turn, turn)};
  }
  if (model.robots[0].profile.kinematics() == Kinematics::differential) state.velocity.vy = draw(0.1, 0.2);
  for (std::size_t w = 0; w < static_cast<std::size_t>(model.robots[0].profile.body.wheels.wheel_count()); ++w) {
    state.wheel_speeds[w] = seldom() ? draw(-80.0, 80.0) : state.velocity.vx / 0.0325 + draw(-1.0, 1.0);
    state.wheel_angles[w] = draw(-1e3, 1e3);
  }
  state.distance_driven = draw(0.0, 10.0);
  state.odometry.reading.pose = {draw(-5.0, 5.0), draw(-5.0, 5.0), draw(-M_PI, M_PI)};
  for (std::size_t w = 0; w < 4; ++w) state.odometry.read[w] = state.wheel_angles[w] - draw(-0.5, 0.5);
  return state;
}

Velocity random_command(const RngKey& key, std::uint64_t i) {
  const double size = uniform(key, i, 10) < 0.3 ? 3.0 : 0.5;
  return {uniform(key, i, 11, -size, size), uniform(key, i, 12, -size, size), uniform(key, i, 13, -4.0, 4.0)};
}

template <class T>
bool same(const T& a, const T& b) {
  using Bytes = std::array<std::byte, sizeof(T)>;
  return std::bit_cast<Bytes>(a) == std::bit_cast<Bytes>(b);
}

}  // namespace

TEST_CASE("many robots, driven at once, do to the bit what each would alone, on every target") {
  const auto all = models_of_all_kinds();
  const std::vector<std::string> targets = available_targets();
  CHECK(targets.size() >= 2);
  for (const std::string& target : targets) {
    CAPTURE(target);
    force_target(target);
    std::uint64_t robots = 0;
    for (std::uint64_t seed = 0; seed < cases(1'000); ++seed) {
      CAPTURE(seed);
      const RngKey key{.seed = seed};
      // vectors of one model, and of several; whole ones, and what is left over
      const bool mixed = uniform(key, 0) < 0.5;
      const auto count = static_cast<std::size_t>(uniform(key, 1, 0, 0.0, 20.0));
      std::vector<RobotState> states;
      std::vector<kernel::Driver> drivers;
      for (std::size_t i = 0; i < count; ++i) {
        const Model& model = *all[(mixed ? seed + i * i : seed) % all.size()];
        states.push_back(random_state(model, key, 100 + i));
        states.back().commands[i % kMaxLatencySteps] = random_command(key, 200 + i);
        drivers.push_back({&model.robots[0], nullptr, nullptr, i % 3 == 0 ? 0.3 : 1.0});
      }
      std::vector<RobotState> expected = states;
      std::vector<kernel::Driven> driven(count);
      for (std::size_t i = 0; i < count; ++i) {
        drivers[i].state = &states[i];
        drivers[i].command = &states[i].commands[i % kMaxLatencySteps];
      }
      kernel::drive(drivers, driven);
      for (std::size_t i = 0; i < count; ++i) {
        CAPTURE(i);
        drivers[i].state = &expected[i];
        const kernel::Driven twin = plain::drive(drivers[i]);
        REQUIRE(same(driven[i], twin));
        REQUIRE(same(states[i], expected[i]));
      }

      for (std::size_t i = 0; i < count; ++i) drivers[i].state = &states[i];
      kernel::measure_odometry(drivers);
      for (std::size_t i = 0; i < count; ++i) {
        CAPTURE(i);
        plain::measure_odometry(drivers[i].robot->odometer, expected[i]);
        REQUIRE(same(states[i], expected[i]));
      }
      robots += count;
    }
    CHECK(robots > cases(8'000));
  }
  force_target("");
}

TEST_CASE("what is worked out beforehand is the kinematics of the wheels") {
  for (const char* name : {"3we_standard_v2", "turtlebot_like"}) {
    const RobotProfile profile = load_profile(name);
    const models::Drive drive = models::make_drive(profile, kStep);
    for (const Velocity& v : {Velocity{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}, {0.4, -0.3, 0.8}}) {
      const WheelSpeeds expected = wheel_speeds(profile.body.wheels, v);
      const WheelSpeeds speeds = plain::setpoints(drive, v);
      const Velocity there_and_back = body_velocity(profile.body.wheels, expected);
      const Velocity rolling = plain::rolling_velocity(drive, speeds);
      for (std::size_t i = 0; i < 4; ++i) CHECK(speeds[i] == doctest::Approx(expected[i]).epsilon(1e-12));
      CHECK(rolling.vx == doctest::Approx(there_and_back.vx).epsilon(1e-12));
      CHECK(rolling.vy == doctest::Approx(there_and_back.vy).epsilon(1e-12));
      CHECK(rolling.omega == doctest::Approx(there_and_back.omega).epsilon(1e-12));
    }
  }
}
