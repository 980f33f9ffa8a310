// Each knob of the physics changes what it should, by as much as it should, and nothing else.
#include "threewe/models/randomization.hpp"

#include <doctest/doctest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "sim/step.hpp"

using namespace threewe;
using namespace threewe::sim;

namespace {

// A hall of 40 x 40 m with nothing in it.
std::shared_ptr<const scene::Scene> hall() {
  scene::Scene scene;
  scene.name = "hall";
  scene.min = {-20.0, -20.0};
  scene.max = {20.0, 20.0};
  const Vec2 corners[] = {{-20.0, -20.0}, {20.0, -20.0}, {20.0, 20.0}, {-20.0, 20.0}};
  for (std::size_t i = 0; i < 4; ++i) scene.walls.push_back({corners[i], corners[(i + 1) % 4], 0.1, 2.5});
  scene.starts = {{}, {2.0, 0.0, 0.0}};
  return std::make_shared<const scene::Scene>(scene);
}

RobotProfile profile() {
  RobotProfile robot = load_profile("3we_standard_v2");
  robot.lidar.reset();
  robot.ultrasonics.reset();
  return robot;
}

const Model& model() {
  static const auto made = make_model(hall(), {profile()});
  return *made;
}

RobotState drive(const models::Variation& variation, const Velocity& command, int steps, const Model& in = model()) {
  RobotState state = begin(in, 0, {}, 5, 0, variation);
  for (int i = 0; i < steps; ++i) step(in, {&state, 1}, {&command, 1});
  return state;
}

// Back and forth, with slip, so that every part of the drive has its say.
RobotState drive_about(const models::Variation& variation) {
  RobotState state = begin(model(), 0, {}, 5, 0, variation);
  const Velocity commands[] = {{1.2, 0.0, 0.0}, {-0.4, 0.9, 1.0}, {0.0, -1.1, -3.0}, {}};
  for (int i = 0; i < 400; ++i) step(model(), {&state, 1}, {&commands[i / 40 % 4], 1});
  return state;
}

// Every byte but those that say what was varied.
bool same_but_for_the_knob(RobotState a, RobotState b) {
  a.variation = b.variation = {};
  using Bytes = std::array<std::byte, sizeof(RobotState)>;
  return std::bit_cast<Bytes>(a) == std::bit_cast<Bytes>(b);
}

}  // namespace

TEST_CASE("a variation of ones is the profile, to the bit") {
  const RobotState plain = begin(model(), 0, {}, 5);
  CHECK(plain.traction.mass == profile().body.mass);
  CHECK(plain.battery_resistance == profile().battery->resistance);
  CHECK(plain.command_latency == 4);
  CHECK(same_but_for_the_knob(drive_about({}), drive_about(models::Variation{})));
  // what is drawn for other parts leaves the physics alone
  CHECK(same_but_for_the_knob(drive_about({}), drive_about({.camera_noise = 3.0, .light = 0.5, .texture = 7.0})));
}

TEST_CASE("each knob of the physics alone changes how a robot drives") {
  const RobotState plain = drive_about({});
  const std::vector<std::pair<std::string, models::Variation>> knobs{
      {"mass", {.mass = 1.1}},
      {"friction", {.friction = 0.8}},
      {"motor_lag", {.motor_lag = 1.5}},
      {"motor_noise", {.motor_noise = 0.05}},
      {"battery_charge", {.battery_charge = 0.3}},
      {"battery_resistance", {.battery_resistance = 3.0}},
      {"odometry_slip", {.odometry_slip = 1.5}},
      {"command_latency", {.command_latency = 2.0}},
  };
  for (const auto& [name, variation] : knobs) {
    CAPTURE(name);
    CHECK_FALSE(same_but_for_the_knob(plain, drive_about(variation)));
    const RobotState begun = begin(model(), 0, {}, 5, 0, variation);
    const RobotState nominal = begin(model(), 0, {}, 5);
    // what belongs to other knobs is as it was
    CHECK((begun.traction.mass == nominal.traction.mass) == (name != "mass"));
    CHECK((begun.traction.stall_change == nominal.traction.stall_change) == (name != "mass"));
    CHECK((begun.traction.friction_change == nominal.traction.friction_change) == (name != "friction"));
    CHECK((begun.traction.response == nominal.traction.response) == (name != "motor_lag"));
    CHECK((begun.traction.motor_noise == nominal.traction.motor_noise) == (name != "motor_noise"));
    CHECK((begun.battery.charge == nominal.battery.charge) == (name != "battery_charge"));
    CHECK((begun.battery_resistance == nominal.battery_resistance) == (name != "battery_resistance"));
    CHECK((begun.wheel_errors.scale == nominal.wheel_errors.scale) == (name != "odometry_slip"));
    CHECK((begun.wheel_errors.lateral == nominal.wheel_errors.lateral) == (name != "odometry_slip"));
    CHECK((begun.command_latency == nominal.command_latency) == (name != "command_latency"));
    CHECK(begun.imu_state.gyro_bias == nominal.imu_state.gyro_bias);
  }
}

TEST_CASE("mass: torque accelerates less of it in proportion; friction does not care; all of its motion is paid for") {
  // so weak motors that torque is what limits them
  RobotProfile weak = profile();
  weak.body.stall_torque = 0.02;
  const auto slow = make_model(hall(), {weak});
  const double light = drive({.mass = 0.8}, {1.2, 0.0, 0.0}, 6, *slow).velocity.vx;
  const double heavy = drive({.mass = 1.25}, {1.2, 0.0, 0.0}, 6, *slow).velocity.vx;
  CHECK(light / heavy == doctest::Approx(1.25 / 0.8).epsilon(0.01));

  // wheels that spin pull with what friction gives, which is a share of the weight
  const auto spun = [](double mass) {
    RobotState state = begin(model(), 0, {}, 5, 0, {.mass = mass});
    for (double& speed : state.wheel_speeds) speed = 30.0;
    const Velocity none;
    step(model(), {&state, 1}, {&none, 1});
    return state.velocity.vx;
  };
  CHECK(spun(0.8) == spun(1.25));

  const auto spent = [](double mass) { return 1.0 - drive({.mass = mass}, {0.5, 0.0, 0.0}, 500).battery.charge; };
  const double idle = 1.0 - drive({}, {}, 500).battery.charge;
  CHECK((spent(1.2) - idle) / (spent(0.8) - idle) == doctest::Approx(1.2 / 0.8).epsilon(0.02));
}

TEST_CASE("mass: what a robot gives to another that it runs into is its share of both masses") {
  const auto pair = make_model(hall(), {profile(), profile()});
  for (const double mass : {0.5, 1.0, 2.0}) {
    std::vector<RobotState> states{begin(*pair, 0, {}, 1, 0, {.mass = mass}), begin(*pair, 1, {0.2505, 0.0, 0.0}, 1)};
    states[0].velocity.vx = 1.0;
    for (double& speed : states[0].wheel_speeds) speed = 1.0 / profile().body.wheels.radius;
    for (Velocity& command : states[0].commands) command = {1.0, 0.0, 0.0};
    const std::vector<Velocity> commands(2);
    step(*pair, states, commands);
    // one body after the impact
    CHECK(states[1].velocity.vx == doctest::Approx(mass / (mass + 1.0)).epsilon(1e-6));
    CHECK(mass * states[0].velocity.vx + states[1].velocity.vx == doctest::Approx(mass * 1.0).epsilon(1e-9));
  }
}

TEST_CASE("friction: what spinning wheels give, in proportion") {
  for (const double friction : {0.8, 1.0, 1.2}) {
    RobotState state = begin(model(), 0, {}, 5, 0, {.friction = friction});
    for (double& speed : state.wheel_speeds) speed = 45.0;
    const Velocity none;
    step(model(), {&state, 1}, {&none, 1});
    CHECK(state.velocity.vx == doctest::Approx(friction * profile().body.friction * 9.80665 * 0.01));
  }
}

TEST_CASE("motor_lag: the time constant of a small change of speed") {
  for (const double lag : {0.5, 1.0, 2.0}) {
    CAPTURE(lag);
    // commanded at once, obeyed after 4 steps, looked at 6 steps later
    const RobotState state = drive({.motor_lag = lag}, {0.02, 0.0, 0.0}, 10);
    CHECK(state.velocity.vx == doctest::Approx(0.02 * (1.0 - std::exp(-0.06 / (lag * 0.03)))).epsilon(1e-9));
  }
}

TEST_CASE("motor_noise: other in each seed, none where no torque is asked for") {
  const auto noisy = [](std::uint64_t seed, const Velocity& command) {
    RobotState state = begin(model(), 0, {}, seed, 0, {.motor_noise = 0.2});
    for (int i = 0; i < 100; ++i) step(model(), {&state, 1}, {&command, 1});
    return state;
  };
  CHECK(noisy(1, {}).wheel_speeds == WheelSpeeds{});
  CHECK(noisy(1, {0.5, 0.0, 0.0}).wheel_angles == noisy(1, {0.5, 0.0, 0.0}).wheel_angles);
  CHECK(noisy(1, {0.5, 0.0, 0.0}).wheel_angles != noisy(2, {0.5, 0.0, 0.0}).wheel_angles);
  // the speed loop holds the speed all the same
  CHECK(noisy(1, {0.5, 0.0, 0.0}).velocity.vx == doctest::Approx(0.5).epsilon(0.05));
}

TEST_CASE("battery_charge and battery_resistance: voltage as a battery of that charge and that resistance has it") {
  const BatterySpec spec = *profile().battery;
  CHECK(begin(model(), 0, {}, 5, 0, {.battery_charge = 0.25}).battery.charge == 0.25);
  for (const double charge : {0.1, 0.5, 1.0}) {
    for (const double factor : {0.0, 1.0, 4.0}) {
      const BatteryState battery =
          begin(model(), 0, {}, 5, 0, {.battery_charge = charge, .battery_resistance = factor}).battery;
      const double open = spec.voltage_empty + (spec.voltage_full - spec.voltage_empty) * charge;
      CHECK(battery.voltage == doctest::Approx(open - factor * spec.resistance * battery.current).epsilon(1e-12));
      CHECK(battery.voltage * battery.current == doctest::Approx(spec.idle_power));
    }
  }
  // a flat one moves nothing; a sagging one pulls less
  CHECK(drive({.battery_charge = 0.0}, {1.0, 0.0, 0.0}, 100).pose.x == 0.0);
  CHECK(drive({.battery_resistance = 8.0}, {1.2, 0.0, 0.0}, 20).battery.voltage <
        drive({}, {1.2, 0.0, 0.0}, 20).battery.voltage - 0.5);
}

TEST_CASE("odometry_slip: none, and odometry sideways is the truth") {
  const auto shortfall = [](double slip) {
    const RobotState state = drive({.odometry_slip = slip}, {0.0, 0.2, 0.0}, 300);
    return 1.0 - state.pose.y / state.odometry.reading.pose.y;
  };
  CHECK(std::fabs(shortfall(0.0)) < 0.003);
  CHECK(shortfall(1.0) > 0.02);
  CHECK(shortfall(2.0) > 1.7 * shortfall(1.0));
}

TEST_CASE("lidar_noise and lidar_dropout: errors grow in proportion, lost points in number, each alone") {
  RobotProfile robot = load_profile("3we_standard_v2");
  robot.ultrasonics.reset();
  robot.lidar->range_max = 100.0;
  const auto seeing = make_model(hall(), {robot});
  const auto scan = [&](const models::Variation& variation) {
    RobotState state = begin(*seeing, 0, {}, 5, 0, variation);
    const Velocity none;
    for (int i = 0; i < seeing->robots[0].turn; ++i) step(*seeing, {&state, 1}, {&none, 1});
    const auto points = scan_points(seeing->robots[0], state);
    return std::vector<double>(points.begin(), points.end());
  };
  const auto truth = scan({.lidar_noise = 0.0, .lidar_dropout = 0.0});
  const auto plain = scan({});
  const auto noisy = scan({.lidar_noise = 3.0});
  int lost = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    CHECK(truth[i] > 19.0);
    CHECK((noisy[i] == 0.0) == (plain[i] == 0.0));  // the same points are lost
    lost += plain[i] == 0.0 ? 1 : 0;
    if (plain[i] == 0.0) continue;
    CHECK(noisy[i] - truth[i] == doctest::Approx(3.0 * (plain[i] - truth[i])).scale(1.0).epsilon(1e-5));
  }
  CHECK(plain != truth);

  const auto losing = scan({.lidar_dropout = 20.0});
  int lost_more = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    lost_more += losing[i] == 0.0 ? 1 : 0;
    if (losing[i] != 0.0) CHECK(losing[i] == plain[i]);
  }
  CHECK(lost < 20);  // 1 % of 450
  CHECK(lost_more == doctest::Approx(90).epsilon(0.3));
}

TEST_CASE("imu_noise: biases and scatter in proportion") {
  const auto samples = [](double noise) {
    RobotState state = begin(model(), 0, {}, 5, 0, {.imu_noise = noise});
    const Velocity none;
    std::vector<double> values;
    for (int i = 0; i < 50; ++i) {
      step(model(), {&state, 1}, {&none, 1});
      for (std::size_t axis = 0; axis < 3; ++axis) {
        values.push_back(state.imu.angular_velocity[axis]);
        values.push_back(state.imu.linear_acceleration[axis]);
      }
    }
    return values;
  };
  const auto truth = samples(0.0);
  const auto plain = samples(1.0);
  const auto noisy = samples(4.0);
  CHECK(plain != truth);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    CHECK(noisy[i] - truth[i] == doctest::Approx(4.0 * (plain[i] - truth[i])).scale(1.0).epsilon(1e-9));
  }
}

TEST_CASE("command_latency: whole steps, as many as a state has room for") {
  const auto steps_until_motion = [](double factor) {
    for (int steps = 1;; ++steps) {
      if (drive({.command_latency = factor}, {0.5, 0.0, 0.0}, steps).velocity.vx > 0.0) return steps - 1;
    }
  };
  CHECK(steps_until_motion(0.0) == 0);
  CHECK(steps_until_motion(1.0) == 4);
  CHECK(steps_until_motion(1.1) == 4);
  CHECK(steps_until_motion(1.2) == 5);
  CHECK(steps_until_motion(3.0) == 12);
  CHECK(steps_until_motion(100.0) == kMaxLatencySteps - 1);
}
