#include "sim/step.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <map>
#include <thread>
#include <utility>
#include <vector>

#include "draw.hpp"
#include "sim/placement.hpp"
#include "threewe/core/errors.hpp"

using namespace threewe;
using namespace threewe::sim;

namespace {

std::shared_ptr<const scene::Scene> office() {
  static const auto scene = std::make_shared<const scene::Scene>(scene::Scene::load("office_v2"));
  return scene;
}

// A hall of 20 x 20 m with nothing in it, but patches of floor.
std::shared_ptr<const scene::Scene> hall(std::vector<scene::Patch> patches = {}) {
  scene::Scene scene;
  scene.name = "hall";
  scene.min = {-10.0, -10.0};
  scene.max = {10.0, 10.0};
  const Vec2 corners[] = {{-10.0, -10.0}, {10.0, -10.0}, {10.0, 10.0}, {-10.0, 10.0}};
  for (std::size_t i = 0; i < 4; ++i) scene.walls.push_back({corners[i], corners[(i + 1) % 4], 0.1, 2.5});
  scene.starts = {{}, {2.0, 0.0, 0.0}};
  scene.patches = std::move(patches);
  return std::make_shared<const scene::Scene>(scene);
}

RobotProfile standard(NoiseLevel noise = NoiseLevel::realistic) {
  return with_noise(load_profile("3we_standard_v2"), noise);
}
RobotProfile differential(NoiseLevel noise = NoiseLevel::realistic) {
  return with_noise(load_profile("turtlebot_like"), noise);
}
RobotProfile without_sensors(RobotProfile profile) {
  profile.lidar.reset();
  profile.imu.reset();
  profile.ultrasonics.reset();
  return profile;
}

// Models are made once: finding out what can be seen from where takes a moment.
const Model& model_of(const std::string& name) {
  static const std::map<std::string, std::shared_ptr<const Model>> models{
      {"hall ideal", make_model(hall(), {standard(NoiseLevel::ideal)})},
      {"hall real", make_model(hall(), {standard()})},
      {"hall differential", make_model(hall(), {differential(NoiseLevel::ideal)})},
      {"office", make_model(office(), {standard()})},
      {"office differential", make_model(office(), {differential()})},
      {"pair", make_model(hall(), {standard(), differential()})},
  };
  return *models.at(name);
}

void run(const Model& model, RobotState& state, const Velocity& command, Duration duration) {
  for (Duration t{}; t < duration; t += kStep) step(model, {&state, 1}, {&command, 1});
}

// Every byte: no padding hides in a state, and -0.0 or another NaN would be a difference.
bool same(const RobotState& a, const RobotState& b) {
  using Bytes = std::array<std::byte, sizeof(RobotState)>;
  return std::bit_cast<Bytes>(a) == std::bit_cast<Bytes>(b);
}

Velocity random_command(const RngKey& key, std::uint64_t i, bool holonomic) {
  return {uniform(key, i, 0, -1.5, 1.5), holonomic ? uniform(key, i, 1, -1.5, 1.5) : 0.0,
          uniform(key, i, 2, -3.5, 3.5)};
}

}  // namespace

TEST_CASE("a metre driven is a metre: for the truth, the wheels and the lidar") {
  const Model& model = model_of("hall ideal");
  RobotState state = begin(model, 0, {}, 1);
  run(model, state, {}, 100ms);
  const float ahead_before =
      models::make_scan(*model.robots[0].profile.lidar, scan_points(model.robots[0], state)).ranges[180];
  run(model, state, {0.5, 0.0, 0.0}, 2s);
  run(model, state, {}, 1s);
  const float ahead_after =
      models::make_scan(*model.robots[0].profile.lidar, scan_points(model.robots[0], state)).ranges[180];

  // 2 s at 0.5 m/s: the lag at the start is made up for at the end
  CHECK(state.pose.x == doctest::Approx(1.0).epsilon(1e-3));
  CHECK(state.pose.y == 0.0);
  CHECK(state.distance_driven == doctest::Approx(state.pose.x));
  CHECK(state.odometry.reading.pose.x == doctest::Approx(state.pose.x).epsilon(1e-6));
  CHECK(static_cast<double>(ahead_before - ahead_after) == doctest::Approx(state.pose.x).epsilon(1e-4));
  // the wall's face is 9.95 m from the start, the lidar 4 cm ahead of the base
  CHECK(static_cast<double>(ahead_before) == doctest::Approx(9.91).epsilon(1e-4));
}

TEST_CASE("forward is +x, left is +y, and turning left is positive, for every sensor") {
  const Model& model = model_of("hall ideal");
  RobotState state = begin(model, 0, {1.0, 2.0, M_PI / 2}, 1);
  run(model, state, {0.2, 0.0, 0.0}, 1s);
  CHECK(state.pose.y > 2.15);
  CHECK(state.imu.linear_acceleration[0] == doctest::Approx(0.0).scale(1.0).epsilon(0.01));

  state = begin(model, 0, {1.0, 2.0, M_PI / 2}, 1);
  run(model, state, {0.0, 0.2, 0.0}, 1s);
  CHECK(state.pose.x < 0.85);
  CHECK(state.odometry.reading.pose.y == doctest::Approx(1.0 - state.pose.x).epsilon(1e-3));
  CHECK(state.odometry.reading.velocity.vy == doctest::Approx(0.2).epsilon(1e-3));

  state = begin(model, 0, {1.0, 2.0, M_PI / 2}, 1);
  run(model, state, {0.0, 0.0, 1.0}, 50ms);
  run(model, state, {0.0, 0.0, 1.0}, 1s);
  CHECK(state.pose.theta > M_PI / 2 + 0.9);
  CHECK(state.imu.angular_velocity[2] == doctest::Approx(1.0).epsilon(1e-3));
  CHECK(state.odometry.reading.velocity.omega == doctest::Approx(1.0).epsilon(1e-3));

  // speeding up pushes forward
  state = begin(model, 0, {}, 1);
  run(model, state, {0.5, 0.0, 0.0}, kStep);
  CHECK(state.imu.linear_acceleration[0] > 1.0);
  CHECK(std::fabs(state.imu.linear_acceleration[1]) < 1e-9);
  // and a bend to the left pushes left: v * omega
  run(model, state, {0.5, 0.0, 1.0}, 2s);
  CHECK(state.imu.linear_acceleration[1] == doctest::Approx(0.5 * 1.0).epsilon(0.01));
}

TEST_CASE("the wheels of a robot that does not slip tell its path, whatever it drives") {
  for (const char* name : {"hall ideal", "hall differential"}) {
    CAPTURE(name);
    const Model& model = model_of(name);
    const double gentle = std::string(name) == "hall ideal" ? 0.4 : 0.15;
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      CAPTURE(seed);
      const RngKey key{.seed = seed};
      RobotState state = begin(model, 0, {1.0, -1.0, 0.5}, seed);
      Velocity command;
      for (std::uint64_t i = 0; i < 100; ++i) {
        // small changes, so that friction always suffices
        command.vx += uniform(key, i, 0, -0.02, 0.02);
        command.omega += uniform(key, i, 2, -0.05, 0.05);
        command.vx = std::clamp(command.vx, -gentle, gentle);
        run(model, state, command, 100ms);
      }
      const Pose2D by_wheels = Pose2D{1.0, -1.0, 0.5} * state.odometry.reading.pose;
      CHECK(distance(by_wheels.position(), state.pose.position()) < 1e-4);
      CHECK(wrap_angle(by_wheels.theta - state.pose.theta) == doctest::Approx(0.0).scale(1.0).epsilon(1e-6));
    }
  }
}

TEST_CASE("friction bounds every change of velocity") {
  const Model& model = model_of("hall ideal");
  RobotProfile icy = standard(NoiseLevel::ideal);
  icy.body.friction = 0.1;
  const auto ice = make_model(hall(), {icy});
  for (const Model* floor : {&model, ice.get()}) {
    const double limit = floor->robots[0].profile.body.friction * 9.80665;
    RobotState state = begin(*floor, 0, {}, 1);
    double fastest = 0.0;
    for (int i = 0; i < 300; ++i) {
      const Velocity command = i / 50 % 2 == 0 ? Velocity{1.2, 0.0, 0.0} : Velocity{-0.5, 1.0, 0.0};
      step(*floor, {&state, 1}, {&command, 1});
      CHECK(std::hypot(state.imu.linear_acceleration[0], state.imu.linear_acceleration[1]) <= limit * (1 + 1e-9));
      fastest = std::max(fastest, std::hypot(state.velocity.vx, state.velocity.vy));
    }
    CHECK(fastest <= 1.2 * (1 + 1e-9));
  }
  // on ice the wheels say more than the robot drove
  RobotState state = begin(*ice, 0, {}, 1);
  run(*ice, state, {1.2, 0.0, 0.0}, 300ms);
  CHECK(state.odometry.reading.pose.x > 1.5 * state.pose.x);
}

TEST_CASE("a robot stands within a quarter of a second from half a metre per second") {
  for (const char* name : {"hall real", "office"}) {
    const Model& model = model_of(name);
    RobotState state = begin(model, 0, {}, 1);
    run(model, state, {0.5, 0.0, 0.0}, 1s);
    CHECK(state.velocity.vx == doctest::Approx(0.5).epsilon(1e-3));
    // the limit on braking, as the gate keeps it: a new command every control period
    const double braking = model.robots[0].profile.operating_limits.linear_braking;
    double speed = 0.5;
    Duration taken{};
    while (std::fabs(state.velocity.vx) > 0.01) {
      speed = std::max(speed - braking * 0.02, 0.0);
      run(model, state, {speed, 0.0, 0.0}, 20ms);
      taken += 20ms;
      REQUIRE(taken < 1s);
    }
    CHECK(taken <= 250ms);
  }
}

TEST_CASE("commands take effect after their latency") {
  const Model& model = model_of("hall real");
  RobotState state = begin(model, 0, {}, 1);
  run(model, state, {0.5, 0.0, 0.0}, 40ms);
  CHECK(state.velocity == Velocity{});
  run(model, state, {}, kStep);
  CHECK(state.velocity.vx > 0.0);
  run(model, state, {}, 30ms);
  const double top = state.velocity.vx;
  run(model, state, {}, kStep);
  CHECK(state.velocity.vx < top);
}

TEST_CASE("driving costs the energy of motion and of rolling, over the drive's efficiency") {
  const Model& model = model_of("hall ideal");
  const RobotProfile& profile = model.robots[0].profile;
  RobotState state = begin(model, 0, {-5.0, 0.0, 0.0}, 1);
  // gently, so that no wheel slips
  for (int i = 1; i <= 100; ++i) run(model, state, {0.005 * i, 0.0, 0.0}, kStep);
  run(model, state, {0.5, 0.0, 0.0}, 9s);
  const double spent = (1.0 - state.battery.charge) * profile.battery->capacity * 3600.0;
  const double motion = 0.5 * profile.body.mass * 0.5 * 0.5;
  const double rolling = profile.body.rolling_resistance * profile.body.mass * 9.80665 * state.distance_driven;
  CHECK(spent - profile.battery->idle_power * 10.0 ==
        doctest::Approx((motion + rolling) / profile.battery->drive_efficiency).epsilon(0.02));
}

TEST_CASE("wheels that spin on ice are paid for") {
  RobotProfile icy = standard(NoiseLevel::ideal);
  icy.body.friction = 0.05;
  const auto ice = make_model(hall(), {icy});
  RobotState state = begin(*ice, 0, {}, 1);
  run(*ice, state, {1.0, 0.0, 0.0}, 1s);
  // friction's force times the wheels' speed, twice what reaches the body, while they spin at a steady 1 m/s
  const double spent = (1.0 - state.battery.charge) * icy.battery->capacity * 3600.0 - icy.battery->idle_power;
  const double reached = 0.5 * icy.body.mass * state.velocity.vx * state.velocity.vx;
  const double rolling = icy.body.rolling_resistance * icy.body.mass * 9.80665 * 1.0;
  CHECK(spent * icy.battery->drive_efficiency - rolling > 3.0 * reached);
}

TEST_CASE("a robot whose battery runs out grows slower, and stops for good") {
  RobotProfile profile = standard();
  profile.hardware_limits.linear = 1.56;  // all that its motors can
  profile.battery->capacity = 0.1;
  const auto model = make_model(hall(), {profile});
  RobotState state = begin(*model, 0, {}, 1);
  const auto speed_after = [&](Duration duration) {
    run(*model, state, {0.0, 0.0, 3.0}, duration);
    return state.velocity.omega;
  };
  CHECK(speed_after(2s) == doctest::Approx(3.0).epsilon(0.05));
  const double full = state.battery.voltage;
  const double while_driving = speed_after(20s);
  CHECK(while_driving > 2.5);
  CHECK(state.battery.voltage < full - 1.0);
  run(*model, state, {0.0, 0.0, 3.0}, 30s);
  CHECK(state.battery.charge == 0.0);
  run(*model, state, {0.0, 0.0, 3.0}, 60s);
  CHECK(std::fabs(state.velocity.omega) < 1e-2);
}

TEST_CASE("mecanum rollers lose part of a sideways motion, and odometry does not know") {
  const Model& model = model_of("hall real");
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    RobotState state = begin(model, 0, {}, seed);
    run(model, state, {0.0, 0.3, 0.0}, 3s);
    const double share = state.pose.y / state.odometry.reading.pose.y;
    CHECK(share > 0.85 * 0.98);
    CHECK(share < 0.98 * 1.02);
  }
}

TEST_CASE("thousands of random drives through the office enter nothing, and gain no speed") {
  for (const char* name : {"office", "office differential"}) {
    CAPTURE(name);
    const bool holonomic = std::string(name) == "office";
    const auto model = make_model(office(), {without_sensors(model_of(name).robots[0].profile)});
    const Model& blind = *model;
    std::uint64_t hits = 0;
    double driven = 0.0;
    for (std::uint64_t seed = 0; seed < cases(1500); ++seed) {
      CAPTURE(seed);
      const RngKey key{.seed = seed, .stream = Stream::sampler};
      // anywhere in the building
      Pose2D start;
      for (std::uint64_t i = 0;; ++i) {
        start = {uniform(key, i, 0, office()->min.x, office()->max.x),
                 uniform(key, i, 1, office()->min.y, office()->max.y), uniform(key, i, 2, -M_PI, M_PI)};
        if (!find_collision(blind, 0, start)) break;
      }
      RobotState state = begin(blind, 0, start, seed);
      Velocity command;
      for (std::uint64_t i = 0; i < 300; ++i) {
        if (i % 60 == 0) command = random_command(key, 1000 + i, holonomic);
        step(blind, {&state, 1}, {&command, 1});
        // by the scene's own test of solids, in which being inside counts too
        if (i % 10 == 9) REQUIRE(find_collision(blind, 0, state.pose) == std::nullopt);
        REQUIRE(std::hypot(state.velocity.vx, state.velocity.vy) < 1.25);
      }
      hits += state.max_collision_speed > 0.05 ? 1 : 0;
      driven += state.distance_driven;
      CHECK(state.max_collision_speed < 1.8);
    }
    CHECK(hits > cases(200));
    CHECK(driven > static_cast<double>(cases(500)));
  }
}

// A hall whose floor is ice where x > 1 m.
std::shared_ptr<const Model> icy_hall(NoiseLevel noise) {
  return make_model(hall({{"ice", {1.0, -10.0}, {10.0, 10.0}, "tile", 0.3}}), {standard(noise)});
}

TEST_CASE("on ice the same command slips more, odometry errs more, and stopping takes longer") {
  struct Outcome {
    double slip = 0.0;           // [m/s] of the wheels against the body, at most
    double odometry_lead = 0.0;  // [m] that odometry was ahead of the truth after speeding up
    double braking = 0.0;        // [m]
  };
  const auto model = icy_hall(NoiseLevel::ideal);
  const RobotModel& robot = model->robots[0];
  const auto speed_up_and_stop = [&](double x) {
    Outcome outcome;
    RobotState state = begin(*model, 0, {x, 0.0, 0.0}, 1);
    for (int i = 0; i < 100; ++i) {
      run(*model, state, {1.0, 0.0, 0.0}, kStep);
      outcome.slip =
          std::max(outcome.slip, body_velocity(robot.profile.body.wheels, state.wheel_speeds).vx - state.velocity.vx);
    }
    run(*model, state, {1.0, 0.0, 0.0}, 1s);
    outcome.odometry_lead = state.odometry.reading.pose.x - (state.pose.x - x);
    const double before = state.pose.x;
    run(*model, state, {}, 2s);
    outcome.braking = state.pose.x - before;
    return outcome;
  };
  const Outcome floor = speed_up_and_stop(-6.0);
  const Outcome ice = speed_up_and_stop(2.0);
  CHECK(ice.slip > 2.0 * floor.slip);
  CHECK(ice.odometry_lead > 2.0 * floor.odometry_lead);
  // v^2 / (2 mu g), and a command latency before it
  const double friction = robot.profile.body.friction * 9.80665;
  CHECK(ice.braking - floor.braking == doctest::Approx(0.5 / (0.3 * friction) - 0.5 / friction).epsilon(0.15));
}

TEST_CASE("a floor that holds everywhere alike and one with ice elsewhere give the same bytes") {
  const auto icy = icy_hall(NoiseLevel::realistic);
  RobotState on_plain = begin(model_of("hall real"), 0, {-5.0, 0.0, 0.3}, 1);
  RobotState beside_ice = begin(*icy, 0, {-5.0, 0.0, 0.3}, 1);
  const RngKey key{.seed = 3, .stream = Stream::sampler};
  for (std::uint64_t i = 0; i < 20; ++i) {
    const Velocity command = random_command(key, i, true);
    run(model_of("hall real"), on_plain, command, 200ms);
    run(*icy, beside_ice, command, 200ms);
    REQUIRE(beside_ice.pose.x < 0.8);
  }
  CHECK(same(on_plain, beside_ice));
}

TEST_CASE("with half of its wheels on ice a robot has the mean of both grips") {
  const auto model = icy_hall(NoiseLevel::ideal);
  for (const auto& [x, friction] : {std::pair(0.5, 1.0), std::pair(1.0, 0.65), std::pair(1.5, 0.3)}) {
    CAPTURE(x);
    RobotState state = begin(*model, 0, {x, 0.0, 0.0}, 1);
    for (double& speed : state.wheel_speeds) speed = 30.0;  // they spin: all that friction gives is used
    run(*model, state, {}, kStep);
    CHECK(state.velocity.vx == doctest::Approx(friction * state.traction.friction_change));
  }
}

TEST_CASE("a robot that pushes along a wall gets on") {
  const Model& model = model_of("hall ideal");
  RobotState state = begin(model, 0, {9.7, 0.0, 0.0}, 1);
  run(model, state, {0.5, 0.5, 0.0}, 4s);
  CHECK(state.pose.x < 9.95 - 0.125);
  CHECK(state.pose.x > 9.95 - 0.13);
  CHECK(state.pose.y > 1.8);
  CHECK(state.max_collision_speed > 0.3);
  CHECK(state.max_collision_speed <= 0.5 * (1 + 1e-6));
}

TEST_CASE("the same seed and commands give the same bytes; another seed does not") {
  const Model& model = model_of("office");
  const auto drive = [&](std::uint64_t seed) {
    const RngKey key{.seed = 9};
    RobotState state = begin(model, 0, {}, seed);
    for (std::uint64_t i = 0; i < 30; ++i) run(model, state, random_command(key, i, true), 100ms);
    return state;
  };
  CHECK(same(drive(1), drive(1)));
  CHECK_FALSE(same(drive(1), drive(2)));
}

TEST_CASE("a copy of the state is all that the future needs") {
  const Model& model = model_of("office");
  const RngKey key{.seed = 10};
  RobotState state = begin(model, 0, {}, 1);
  for (std::uint64_t i = 0; i < 37; ++i) run(model, state, random_command(key, i, true), 50ms);
  RobotState copy = state;
  for (std::uint64_t i = 37; i < 80; ++i) run(model, state, random_command(key, i, true), 50ms);
  for (std::uint64_t i = 37; i < 80; ++i) run(model, copy, random_command(key, i, true), 50ms);
  CHECK(same(copy, state));
}

TEST_CASE("a world does not notice its place in a batch, nor the thread") {
  const Model& model = model_of("office");
  constexpr std::size_t kWorlds = 24;
  const RngKey key{.seed = 11};
  std::vector<RobotState> batch;
  batch.reserve(kWorlds);
  std::vector<RobotState> alone;
  for (std::size_t i = 0; i < kWorlds; ++i) batch.push_back(begin(model, 0, {}, i));
  alone = batch;
  std::vector<RobotState> threaded = batch;
  const auto commands_at = [&](std::uint64_t t) {
    std::vector<Velocity> commands;
    commands.reserve(kWorlds);
    for (std::size_t i = 0; i < kWorlds; ++i) commands.push_back(random_command(key, t * kWorlds + i, true));
    return commands;
  };
  constexpr std::uint64_t kTimes = 15;
  for (std::uint64_t t = 0; t < kTimes; ++t) {
    const auto commands = commands_at(t);
    for (int i = 0; i < 10; ++i) step(model, batch, commands);
    for (std::size_t w = kWorlds; w-- > 0;) run(model, alone[w], commands[w], 100ms);
  }
  std::vector<std::thread> threads;
  threads.reserve(4);
  for (std::size_t part = 0; part < 4; ++part) {
    threads.emplace_back([&, part] {
      for (std::uint64_t t = 0; t < kTimes; ++t) {
        const auto commands = commands_at(t);
        const std::span<RobotState> mine = std::span(threaded).subspan(part * 6, 6);
        for (int i = 0; i < 10; ++i) step(model, mine, std::span(commands).subspan(part * 6, 6));
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (std::size_t i = 0; i < kWorlds; ++i) {
    CAPTURE(i);
    CHECK(same(batch[i], alone[i]));
    CHECK(same(batch[i], threaded[i]));
  }
}

TEST_CASE("each noise switch changes its own sensor and no other") {
  const RngKey key{.seed = 12};
  const auto drive = [&](const RobotProfile& profile) {
    const auto model = make_model(hall(), {profile});
    RobotState state = begin(*model, 0, {}, 5);
    for (std::uint64_t i = 0; i < 20; ++i) run(*model, state, random_command(key, i, true), 50ms);
    return state;
  };
  const RobotState real = drive(standard());
  const auto same_body = [&](const RobotState& other) {
    return other.pose == real.pose && other.velocity == real.velocity;
  };
  const auto same_imu = [&](const RobotState& other) {
    return other.imu.angular_velocity == real.imu.angular_velocity &&
           other.imu.linear_acceleration == real.imu.linear_acceleration;
  };
  const auto same_odometry = [&](const RobotState& other) {
    return other.odometry.reading.pose == real.odometry.reading.pose;
  };
  const auto same_lidar = [&](const RobotState& other) { return other.lidar_points == real.lidar_points; };

  RobotProfile profile = standard();
  profile.lidar->sigma = 0.0;
  RobotState changed = drive(profile);
  CHECK((same_body(changed) && same_imu(changed) && same_odometry(changed) && !same_lidar(changed)));
  profile = standard();
  profile.lidar.reset();
  changed = drive(profile);
  CHECK((same_body(changed) && same_imu(changed) && same_odometry(changed)));
  profile = standard();
  profile.ultrasonics->sigma = 0.0;
  changed = drive(profile);
  CHECK((same_body(changed) && same_imu(changed) && same_odometry(changed) && same_lidar(changed)));
  profile = standard();
  profile.ultrasonics.reset();
  changed = drive(profile);
  CHECK((same_body(changed) && same_imu(changed) && same_odometry(changed) && same_lidar(changed)));
  profile = standard();
  profile.imu->gyro_bias = 0.0;
  changed = drive(profile);
  CHECK((same_body(changed) && !same_imu(changed) && same_odometry(changed) && same_lidar(changed)));
  profile = standard();
  profile.imu.reset();
  changed = drive(profile);
  CHECK((same_body(changed) && same_odometry(changed) && same_lidar(changed)));
  profile = standard();
  profile.odometry.wheel_scale = 0.0;
  changed = drive(profile);
  CHECK((same_body(changed) && same_imu(changed) && !same_odometry(changed) && same_lidar(changed)));
  profile = standard();
  profile.odometry.ticks_per_turn = 0;
  changed = drive(profile);
  CHECK((same_body(changed) && same_imu(changed) && !same_odometry(changed) && same_lidar(changed)));
  // what the body obeys changes what it does, but hardly the wheels (by way of the battery alone)
  profile = standard();
  profile.odometry.lateral_scale_min = profile.odometry.lateral_scale_max = 1.0;
  changed = drive(profile);
  CHECK_FALSE(same_body(changed));
  CHECK(distance(changed.odometry.reading.pose.position(), real.odometry.reading.pose.position()) < 1e-3);
}

TEST_CASE("a rolling scan is taken from where the robot was at each of its points") {
  RobotProfile profile = standard(NoiseLevel::ideal);
  profile.lidar = load_profile("3we_standard_v2").lidar;
  profile.lidar->sigma = profile.lidar->bias = profile.lidar->dropout = 0.0;
  const auto model = make_model(hall(), {profile});
  const LidarSpec& lidar = *profile.lidar;
  RobotState state = begin(*model, 0, {-5.0, 3.0, 0.3}, 1);
  const Velocity command{0.8, 0.0, 2.0};
  run(*model, state, command, 1s);
  std::vector<Pose2D> poses{state.pose};
  for (int i = 0; i < 10; ++i) {
    run(*model, state, command, kStep);
    poses.push_back(state.pose);
  }
  const scene::Slice slice = hall()->at_height(lidar.height);
  const auto points = scan_points(model->robots[0], state);
  const models::ScanPattern pattern = models::scan_pattern(lidar);
  for (std::size_t k = 0; k < 450; ++k) {
    CAPTURE(k);
    const double t = static_cast<double>(k) / 45.0;
    const auto i = static_cast<std::size_t>(t);
    const Pose2D sensor =
        interpolate(poses[i] * lidar.base_from_lidar, poses[i + 1] * lidar.base_from_lidar, t - static_cast<double>(i));
    const double angle = sensor.theta + pattern.first_angle + static_cast<double>(k) * pattern.angle_step;
    CHECK(static_cast<double>(points[k]) ==
          doctest::Approx(scene::cast_ray(slice, sensor.position(), angle, lidar.range_max)).epsilon(1e-4));
  }
}

TEST_CASE("a scan that is taken later, by the path that was kept, is the same to the bit") {
  for (const bool rolling : {true, false}) {
    RobotProfile profile = load_profile("3we_standard_v2");
    profile.lidar->rolling = rolling;
    const auto model = make_model(hall(), {profile});
    const RobotModel& robot = model->robots[0];
    models::Variation variation;
    variation.lidar_noise = 1.5;
    variation.lidar_dropout = 3.0;
    std::vector<RobotState> state{begin(*model, 0, {-5.0, 3.0, 0.3}, 7, 3, variation)};
    std::vector<Pose2D> path(static_cast<std::size_t>(robot.turn) + 1);
    const Velocity command{0.8, 0.2, 2.0};
    for (std::uint64_t turn = 0; turn < 5; ++turn) {
      for (int i = 0; i < robot.turn; ++i) {
        const World world{model.get(), state, std::span(&command, 1), {}, {}, path};
        step(std::span(&world, 1));
      }
      const auto taken = scan_points(robot, state[0]);
      std::vector<float> later(taken.size());
      RobotState elsewhere = state[0];  // by now
      run(*model, elsewhere, command, 130ms);
      retake_scan(robot, elsewhere, turn, path, RayCaster::kEverything, later);
      CHECK(std::ranges::equal(later, taken));
      CHECK(path.back() == state[0].pose);

      constexpr double kReach = 4.0;
      const double error = models::most_too_short(*profile.lidar, state[0].lidar_bias, variation);
      retake_scan(robot, elsewhere, turn, path, kReach + error, later);
      for (std::size_t i = 0; i < later.size(); ++i) {
        if (static_cast<double>(taken[i]) <= kReach)
          CHECK(later[i] == taken[i]);
        else
          CHECK(static_cast<double>(later[i]) > kReach);
      }
    }
  }
}

TEST_CASE("a scan at one moment is taken at the end of the turn") {
  const Model& model = model_of("hall ideal");
  RobotState state = begin(model, 0, {-5.0, 3.0, 0.3}, 1);
  run(model, state, {0.8, 0.2, 2.0}, 1s);
  const LidarSpec& lidar = *model.robots[0].profile.lidar;
  const LaserScan scan = models::make_scan(lidar, scan_points(model.robots[0], state));
  const Pose2D sensor = state.pose * lidar.base_from_lidar;
  const scene::Slice slice = hall()->at_height(lidar.height);
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const double angle = sensor.theta + scan.angle_min + static_cast<double>(i) * scan.angle_increment;
    CHECK(static_cast<double>(scan.ranges[i]) ==
          doctest::Approx(scene::cast_ray(slice, sensor.position(), angle, 12.0)).epsilon(1e-4));
  }
}

TEST_CASE("ultrasonic sensors are pinged in turn, and hear the wall that they look at") {
  const Model& model = model_of("hall ideal");
  const UltrasonicSpec& spec = *model.robots[0].profile.ultrasonics;
  // 2.95 m from the left wall's face, 1.95 m from the one ahead; the other two are out of range
  RobotState state = begin(model, 0, {8.0, 7.0, 0.0}, 1);
  std::map<std::string, double> heard;
  std::vector<std::string> order;
  for (int i = 0; i < 48; ++i) {
    run(model, state, {}, kStep);
    const auto sensor = ping_ready(model.robots[0], state);
    CHECK(sensor.has_value() == (state.time() % 60ms == 0ms));
    if (!sensor) continue;
    order.push_back(spec.mounts[*sensor].name);
    heard[order.back()] = state.ultrasonic_range;
  }
  const std::vector<std::string> turn{"ultrasonic_front_left", "ultrasonic_left", "ultrasonic_front_right",
                                      "ultrasonic_right"};
  REQUIRE(order.size() == 8);
  for (std::size_t i = 0; i < order.size(); ++i) CHECK(order[i] == turn[i % 4]);
  CHECK(heard["ultrasonic_front_left"] == doctest::Approx(1.95 - 0.125));
  CHECK(heard["ultrasonic_front_right"] == doctest::Approx(1.95 - 0.125));
  CHECK(heard["ultrasonic_left"] == doctest::Approx(2.95 - 0.11));
  CHECK(heard["ultrasonic_right"] == spec.range_max);
}

TEST_CASE("what is heard scatters, differently in each episode's seed") {
  const auto hear = [](const RobotProfile& profile, std::uint64_t seed) {
    const auto model = make_model(hall(), {profile});
    RobotState state = begin(*model, 0, {8.0, 0.0, 0.0}, seed);
    run(*model, state, {}, 60ms);
    return state.ultrasonic_range;
  };
  CHECK(hear(standard(), 5) == hear(standard(), 5));
  CHECK(hear(standard(), 5) != hear(standard(), 6));
  CHECK(hear(standard(NoiseLevel::ideal), 5) == hear(standard(NoiseLevel::ideal), 6));
  CHECK(hear(standard(), 5) == doctest::Approx(hear(standard(NoiseLevel::ideal), 5)).epsilon(0.01));
}

TEST_CASE("robots hear one another, where they are as tall as the sound") {
  const Model& model = model_of("pair");
  std::vector<RobotState> world{begin(model, 0, {}, 1), begin(model, 1, {1.5, 0.07, 0.0}, 1)};
  const std::vector<Velocity> still(2);
  for (int i = 0; i < 6; ++i) step(model, world, still);
  CHECK(world[0].ultrasonic_range == doctest::Approx(1.5 - 0.11 - 0.125).epsilon(0.01));

  RobotProfile flat = differential();
  flat.body.height = 0.05;
  const auto low = make_model(hall(), {standard(), flat});
  world = {begin(*low, 0, {}, 1), begin(*low, 1, {1.5, 0.07, 0.0}, 1)};
  for (int i = 0; i < 6; ++i) step(*low, world, still);
  CHECK(world[0].ultrasonic_range == 4.0);
}

TEST_CASE("robots of one world see one another, and stop at one another") {
  const Model& model = model_of("pair");
  std::vector<RobotState> world{begin(model, 0, {}, 1), begin(model, 1, {2.0, 0.0, 0.0}, 1)};
  const std::vector<Velocity> still(2);
  for (int i = 0; i < 10; ++i) step(model, world, still);
  const LaserScan scan = models::make_scan(*model.robots[0].profile.lidar, scan_points(model.robots[0], world[0]));
  // the other's back is 0.11 m behind its base
  CHECK(static_cast<double>(scan.ranges[180]) == doctest::Approx(2.0 - 0.11 - 0.04).epsilon(0.05));

  // the first drives into the other's back, and pushes it a little
  const std::vector<Velocity> commands{{1.0, 0.0, 0.0}, {}};
  for (int i = 0; i < 400; ++i) {
    step(model, world, commands);
    CHECK_FALSE(robots_overlap(model.robots[0], world[0].pose, model.robots[1], world[1].pose));
  }
  const double gap = world[1].pose.x - 0.11 - (world[0].pose.x + 0.125);
  CHECK(gap >= 0.0);
  CHECK(gap < 0.01);
  CHECK(world[1].pose.x > 2.0);
  CHECK(world[0].max_collision_speed > 0.8);
  // the one that was driven into did nothing
  CHECK(world[1].max_collision_speed == 0.0);
}

TEST_CASE("three robots that drive about in a narrow place never overlap one another, nor what stands there") {
  const auto model = make_model(office(), {without_sensors(standard()), without_sensors(differential()),
                                           without_sensors(standard(NoiseLevel::ideal))});
  std::uint64_t met = 0;
  for (std::uint64_t seed = 0; seed < cases(150); ++seed) {
    CAPTURE(seed);
    const RngKey key{.seed = seed, .stream = Stream::sampler};
    std::vector<RobotState> world{begin(*model, 0, {0.0, 0.0, 0.0}, seed), begin(*model, 1, {0.4, 0.0, 1.0}, seed),
                                  begin(*model, 2, {0.0, 0.4, 2.0}, seed)};
    std::vector<Velocity> commands(3);
    for (std::uint64_t i = 0; i < 400; ++i) {
      if (i % 40 == 0) {
        for (std::size_t r = 0; r < 3; ++r) commands[r] = random_command(key, i * 3 + r, r != 1);
      }
      step(*model, world, commands);
      for (std::size_t a = 0; a < 3; ++a) {
        REQUIRE(find_collision(*model, a, world[a].pose) == std::nullopt);
        for (std::size_t b = 0; b < a; ++b) {
          REQUIRE_FALSE(robots_overlap(model->robots[a], world[a].pose, model->robots[b], world[b].pose));
        }
      }
    }
    for (const RobotState& robot : world) met += robot.max_collision_speed > 0.1 ? 1 : 0;
  }
  CHECK(met > cases(100));
}

TEST_CASE("three robots: a copy of their states is all that the future needs, whatever else is in the batch") {
  const auto model = make_model(hall(), {standard(), differential(), standard()});
  const auto begin_all = [&](std::uint64_t seed) {
    return std::vector<RobotState>{begin(*model, 0, {}, seed), begin(*model, 1, {0.4, 0.0, 1.0}, seed),
                                   begin(*model, 2, {0.0, 0.4, 2.0}, seed)};
  };
  const RngKey key{.seed = 13};
  const auto drive = [&](std::vector<RobotState>& world, std::uint64_t from, std::uint64_t to) {
    for (std::uint64_t i = from; i < to; ++i) {
      std::vector<Velocity> commands;
      commands.reserve(world.size());
      for (std::size_t r = 0; r < world.size(); ++r) {
        commands.push_back(random_command(key, i / 20 * 3 + r % 3, r % 3 != 1));
      }
      step(*model, world, commands);
    }
  };
  std::vector<RobotState> fresh = begin_all(1);
  drive(fresh, 0, 150);
  std::vector<RobotState> restored = fresh;
  drive(fresh, 150, 400);
  drive(restored, 150, 400);
  std::vector<RobotState> batch = begin_all(2);
  for (const RobotState& robot : begin_all(1)) batch.push_back(robot);
  drive(batch, 0, 400);
  for (std::size_t i = 0; i < 3; ++i) {
    CAPTURE(i);
    CHECK(same(fresh[i], restored[i]));
    CHECK(same(fresh[i], batch[3 + i]));
  }
}

TEST_CASE("what cannot be simulated is refused with its reason") {
  const auto error_of = [](const RobotProfile& profile) -> std::string {
    try {
      make_model(hall(), {profile});
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  };
  RobotProfile profile = standard();
  profile.imu->period = 5ms;
  CHECK(error_of(profile).find("imu.period of 0.005 s") != std::string::npos);
  profile = standard();
  profile.ultrasonics->interval = 55ms;
  CHECK(error_of(profile).find("ultrasonics.interval of 0.055 s") != std::string::npos);
  profile = standard();
  profile.camera->period = 5ms;
  CHECK(error_of(profile).find("camera.period: at least 0.01 s") != std::string::npos);
  profile = standard();
  profile.lidar->points_per_turn = 455;
  CHECK(error_of(profile).find("455 points cannot be spread") != std::string::npos);
  profile = standard();
  profile.lidar->points_per_turn = 1000;
  CHECK(error_of(profile).find("at most 512") != std::string::npos);
  profile = standard();
  profile.command_latency = 200ms;
  CHECK(error_of(profile).find("command_latency") != std::string::npos);
}
