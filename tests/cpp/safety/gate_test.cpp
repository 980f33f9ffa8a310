#include "safety/gate.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "core/rng.hpp"
#include "draw.hpp"
#include "hardware/limits.hpp"

using namespace threewe;
using namespace threewe::safety;

namespace {

constexpr double kPeriod = to_seconds(kControlPeriod);
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Numbers drawn one after the other from one seed.
class Draws {
 public:
  explicit Draws(std::uint64_t seed) : key_{.seed = seed, .stream = Stream::sampler} {}
  double operator()(double low, double high) { return uniform(key_, count_++, 0, low, high); }
  bool coin() { return (*this)(0.0, 1.0) < 0.5; }

 private:
  RngKey key_;
  std::uint64_t count_ = 0;
};

GateModel model(Kinematics kinematics = Kinematics::holonomic) {
  GateModel m;
  m.limits = {
      .linear = 0.5, .angular = 1.0, .linear_acceleration = 1.0, .linear_braking = 2.0, .angular_acceleration = 4.0};
  m.kinematics = kinematics;
  m.footprint = Footprint::rectangle(0.25, 0.22);
  return m;
}

GateModel random_model(Draws& draw) {
  GateModel m = model(draw.coin() ? Kinematics::holonomic : Kinematics::differential);
  m.limits = {.linear = draw(0.1, 1.5),
              .angular = draw(0.3, 3.0),
              .linear_acceleration = draw(0.3, 3.0),
              .linear_braking = draw(0.5, 4.0),
              .angular_acceleration = draw(1.0, 8.0)};
  m.footprint = Footprint::rectangle(draw(0.15, 0.6), draw(0.15, 0.5));
  m.reaction = kControlPeriod * static_cast<int>(draw(0.0, 9.0));
  return m;
}

Velocity random_request(const GateModel& m, Draws& draw) {
  const double lateral = m.kinematics == Kinematics::holonomic ? draw(-2.0, 2.0) : 0.0;
  return {draw(-2.0, 2.0), draw.coin() ? lateral : 0.0, draw(-4.0, 4.0)};
}

// A gate whose scan never grows old.
struct Gate {
  explicit Gate(GateModel m) : model(std::move(m)) { state.scan_seen = true; }
  GateOutput operator()(const Velocity& requested, std::span<const Vec2> obstacles = {}) {
    state.last_scan = now;
    const GateOutput output = gate(model, state, {requested}, {obstacles, {}}, now);
    now += kControlPeriod;
    return output;
  }
  GateModel model;
  GateState state;
  Time now{};
};

double speed(const Velocity& v) { return std::hypot(v.vx, v.vy); }
double change(const Velocity& a, const Velocity& b) { return std::hypot(b.vx - a.vx, b.vy - a.vy); }

// Drives the gate's commands the way a robot does that obeys each one a reaction time late.
struct DelayedRobot {
  DelayedRobot(const GateModel& m, const Pose2D& start) : gate(m), pose(start) {
    pipeline.assign(static_cast<std::size_t>(m.reaction / kControlPeriod), Velocity{});
  }
  GateOutput drive(const Velocity& requested, std::span<const Vec2> obstacles_in_world) {
    const GateOutput output = gate(requested, in_base(obstacles_in_world));
    pipeline.push_back(output.command);
    for (int i = 0; i < 4; ++i) {
      pose = integrate(pose, pipeline.front(), kPeriod / 4);
      nearest = std::min(nearest, clearance(obstacles_in_world));
    }
    pipeline.pop_front();
    return output;
  }
  std::vector<Vec2> in_base(std::span<const Vec2> obstacles_in_world) const {
    const double c = std::cos(pose.theta);
    const double s = std::sin(pose.theta);
    std::vector<Vec2> points;
    for (const Vec2 p : obstacles_in_world) {
      const Vec2 d = p - pose.position();
      points.push_back({c * d.x + s * d.y, c * d.y - s * d.x});
    }
    return points;
  }
  double clearance(std::span<const Vec2> obstacles_in_world) const {
    const double sight = gate.model.footprint.circumscribed_radius() + 0.1;
    double least = kInfinity;
    for (const Vec2 p : in_base(obstacles_in_world)) {
      if (norm(p) < sight) least = std::min(least, gate.model.footprint.signed_distance(p));
    }
    return least;
  }
  Gate gate;
  Pose2D pose;
  std::deque<Velocity> pipeline;
  double nearest = kInfinity;
};

std::vector<Vec2> wall(Vec2 a, Vec2 b, double spacing = 0.01) {
  std::vector<Vec2> points;
  const int n = static_cast<int>(distance(a, b) / spacing);
  for (int i = 0; i <= n; ++i) points.push_back(a + (static_cast<double>(i) / n) * (b - a));
  return points;
}

}  // namespace

TEST_CASE("what a robot may do passes unchanged") {
  Gate gate(model());
  const Velocity small{0.02, 0.0, 0.05};
  CHECK(gate(small) == GateOutput{small, Intervention::none});
  CHECK(gate(small) == GateOutput{small, Intervention::none});
  CHECK(gate({}) == GateOutput{{}, Intervention::none});
}

TEST_CASE("a request that is not finite stops the robot") {
  for (const double bad : {std::nan(""), kInfinity, -kInfinity}) {
    for (int component = 0; component < 3; ++component) {
      Gate gate(model());
      for (int i = 0; i < 100; ++i) gate({0.4, 0.0, 0.3});
      Velocity request{0.4, 0.0, 0.3};
      (component == 0 ? request.vx : component == 1 ? request.vy : request.omega) = bad;
      GateOutput output;
      for (int i = 0; i < 20; ++i) output = gate(request);
      CHECK(output == GateOutput{{}, Intervention::limited});
    }
  }
}

TEST_CASE("a request beyond all measure is limited in its direction") {
  for (const double huge : {1e155, 1e200, 1e308, std::numeric_limits<double>::max()}) {
    CAPTURE(huge);
    const std::vector<std::pair<Velocity, Velocity>> cases = {
        {{huge, 0.0, 0.0}, {0.5, 0.0, 0.0}},
        {{-huge, 0.0, huge}, {-0.5, 0.0, 1.0}},
        {{0.6 * huge, -0.8 * huge, -huge}, {0.3, -0.4, -1.0}},
        {{huge, 1.0, 0.0}, {0.5, 0.0, 0.0}},
    };
    for (const auto& [request, expected] : cases) {
      Gate gate(model());
      GateOutput output;
      for (int i = 0; i < 100; ++i) output = gate(request);
      CHECK(output.intervention == Intervention::limited);
      CHECK(output.command.vx == doctest::Approx(expected.vx));
      CHECK(output.command.vy == doctest::Approx(expected.vy));
      CHECK(output.command.omega == doctest::Approx(expected.omega));
    }
  }
}

TEST_CASE("a velocity beyond the limits keeps its direction") {
  Gate gate(model());
  GateOutput output;
  for (int i = 0; i < 200; ++i) output = gate({3.0, 4.0, 7.0});
  CHECK(output.command.vx == doctest::Approx(0.3));
  CHECK(output.command.vy == doctest::Approx(0.4));
  CHECK(output.command.omega == doctest::Approx(1.0));
  CHECK(output.intervention == Intervention::limited);
}

TEST_CASE("a differential base is never told to move sideways") {
  Gate gate(model(Kinematics::differential));
  GateOutput output;
  for (int i = 0; i < 100; ++i) output = gate({0.2, 0.3, 0.0});
  CHECK(output.command == Velocity{0.2, 0.0, 0.0});
}

TEST_CASE("from 0.5 m/s to stand-still takes at most 0.25 s") {
  Gate gate(model());
  for (int i = 0; i < 200; ++i) gate({0.5, 0.0, 0.0});
  int periods = 0;
  while (gate({}).command != Velocity{}) ++periods;
  CHECK((periods + 1) * kPeriod <= 0.26);
}

TEST_CASE("limits and accelerations hold whatever is asked for, and whatever is in the way") {
  for (std::uint64_t seed = 0; seed < cases(3000); ++seed) {
    CAPTURE(seed);
    Draws draw(seed);
    Gate gate(random_model(draw));
    const Limits& limits = gate.model.limits;
    const double greatest_change = std::max(limits.linear_acceleration, limits.linear_braking) * kPeriod;
    Velocity request;
    for (int i = 0; i < 60; ++i) {
      if (i % 6 == 0) request = random_request(gate.model, draw);
      std::vector<Vec2> obstacles;
      if (draw.coin()) obstacles = {{draw(-0.6, 0.6), draw(-0.6, 0.6)}, {draw(-0.6, 0.6), draw(-0.6, 0.6)}};
      const Velocity last = gate.state.last();
      const Velocity v = gate(request, obstacles).command;
      REQUIRE(is_finite(v));
      REQUIRE(speed(v) <= limits.linear * (1 + 1e-9));
      REQUIRE(std::abs(v.omega) <= limits.angular * (1 + 1e-9));
      REQUIRE(speed(v) <= speed(last) + limits.linear_acceleration * kPeriod * (1 + 1e-9));
      REQUIRE(change(last, v) <= greatest_change * (1 + 1e-9));
      REQUIRE(std::abs(v.omega - last.omega) <= limits.angular_acceleration * kPeriod * (1 + 1e-9));
    }
  }
}

TEST_CASE("what the gate lets through passes it again unchanged") {
  for (std::uint64_t seed = 0; seed < cases(3000); ++seed) {
    CAPTURE(seed);
    Draws draw(seed);
    Gate gate(random_model(draw));
    for (int i = 0; i < 30; ++i) {
      const Velocity request = random_request(gate.model, draw);
      const std::vector<Vec2> obstacles = {{draw(-0.6, 0.6), draw(-0.6, 0.6)}, {draw(-0.6, 0.6), draw(-0.6, 0.6)}};
      Gate again = gate;
      const GateOutput first = gate(request, obstacles);
      REQUIRE(again(first.command, obstacles) == GateOutput{first.command, Intervention::none});
    }
  }
}

TEST_CASE("the same states and requests give the same commands to the bit") {
  for (std::uint64_t seed = 0; seed < cases(200); ++seed) {
    Draws draw(seed);
    Gate one(random_model(draw));
    Gate other = one;
    for (int i = 0; i < 50; ++i) {
      const Velocity request = random_request(one.model, draw);
      const std::vector<Vec2> obstacles = {{draw(-0.6, 0.6), draw(-0.6, 0.6)}};
      REQUIRE(one(request, obstacles) == other(request, obstacles));
      REQUIRE(one.state == other.state);
    }
  }
}

TEST_CASE("the robot drives up to a wall and stops before it") {
  DelayedRobot robot(model(), {});
  const auto obstacles = wall({1.0, -1.0}, {1.0, 1.0});
  GateOutput output;
  for (int i = 0; i < 500; ++i) output = robot.drive({0.5, 0.0, 0.0}, obstacles);
  CHECK(output == GateOutput{{}, Intervention::stopped_for_obstacle});
  CHECK(robot.nearest >= 0.019);
  CHECK(robot.nearest <= 0.025);
}

TEST_CASE("the robot always stops in time, whatever stands around and however it is driven") {
  for (std::uint64_t seed = 0; seed < cases(600); ++seed) {
    CAPTURE(seed);
    Draws draw(seed);
    const GateModel m = random_model(draw);
    DelayedRobot robot(m, {});
    std::vector<Vec2> obstacles;
    while (obstacles.size() < 30) {
      const Vec2 p{draw(-1.5, 1.5), draw(-1.5, 1.5)};
      if (m.footprint.signed_distance(p) > m.margin + 0.01) obstacles.push_back(p);
    }
    Velocity request;
    for (int i = 0; i < 150; ++i) {
      if (i % 25 == 0) request = random_request(m, draw);
      robot.drive(request, obstacles);
    }
    // between two poses of the sweep a corner may come nearer by half the distance between them
    REQUIRE(robot.nearest >= m.margin - 0.0026);
  }
}

TEST_CASE("a robot inside the margin drives out and comes no nearer") {
  for (std::uint64_t seed = 0; seed < cases(300); ++seed) {
    CAPTURE(seed);
    Draws draw(seed);
    const GateModel m = random_model(draw);
    DelayedRobot robot(m, {});
    const double gap = draw(0.0, m.margin);
    const double front = m.footprint.corners()[0].x;
    const auto obstacles = wall({front + gap, -1.0}, {front + gap, 1.0});

    for (int i = 0; i < 50; ++i) robot.drive({0.5, 0.0, draw(-1.0, 1.0)}, obstacles);
    REQUIRE(robot.nearest >= gap - 1e-6);
    for (int i = 0; i < 100; ++i) robot.drive({-0.2, 0.0, 0.0}, obstacles);
    REQUIRE(robot.clearance(obstacles) > gap + 0.05);
  }
}

TEST_CASE("a robot along a wall inside the margin can drive on along it") {
  DelayedRobot robot(model(Kinematics::differential), {});
  const auto obstacles = wall({-1.0, -0.12}, {3.0, -0.12});  // 1 cm beside the robot
  for (int i = 0; i < 200; ++i) robot.drive({0.3, 0.0, 0.0}, obstacles);
  CHECK(robot.pose.x > 0.9);
  CHECK(robot.nearest >= 0.01 - 1e-6);
}

TEST_CASE("touching one obstacle is no licence to touch another") {
  // a false hit inside the outline, and a wall ahead
  std::vector<Vec2> obstacles = wall({0.4, -1.0}, {0.4, 1.0});
  DelayedRobot robot(model(), {});
  for (int i = 0; i < 300; ++i) {
    obstacles.push_back(robot.pose * Vec2{0.10, 0.0});
    const auto real = std::span(obstacles).first(obstacles.size() - 1);
    robot.drive({0.5, 0.0, 0.0}, obstacles);
    obstacles.pop_back();
    REQUIRE(robot.clearance(real) >= -1e-6);
  }
}

TEST_CASE("slowing down for an obstacle keeps to the arc") {
  DelayedRobot robot(model(), {});
  for (int i = 0; i < 100; ++i) robot.drive({0.4, 0.0, 0.8}, {});
  const auto obstacles = wall({robot.pose * Vec2{0.35, -0.5}}, {robot.pose * Vec2{0.35, 0.5}});
  for (int i = 0; i < 40; ++i) {
    const Velocity v = robot.drive({0.4, 0.0, 0.8}, obstacles).command;
    CHECK(v.omega * 0.4 == doctest::Approx(v.vx * 0.8).epsilon(0.01));
  }
  CHECK(robot.nearest >= 0.0174);
}

TEST_CASE("without scans the robot stops, and goes on when they return") {
  GateModel m = model();
  GateState state;
  CHECK(gate(m, state, {{0.3, 0.0, 0.0}}, {}, 0ms) == GateOutput{{}, Intervention::stale_sensors});
  state.scan_seen = true;
  Time now{};
  for (; now <= 500ms; now += kControlPeriod) gate(m, state, {{0.3, 0.0, 0.0}}, {}, now);
  CHECK(state.last().vx == doctest::Approx(0.3));
  GateOutput output;
  for (int i = 0; i < 20; ++i, now += kControlPeriod) output = gate(m, state, {{0.3, 0.0, 0.0}}, {}, now);
  CHECK(output == GateOutput{{}, Intervention::stale_sensors});
  state.last_scan = now;
  CHECK(gate(m, state, {{0.3, 0.0, 0.0}}, {}, now).command.vx > 0.0);
}

TEST_CASE("a robot without a lidar needs no scans") {
  GateModel m = model();
  m.collision_monitor = false;
  GateState state;
  const std::vector<Vec2> ignored = {{0.13, 0.0}};
  CHECK(gate(m, state, {{0.3, 0.0, 0.0}}, {ignored, {}}, 10s).command.vx == doctest::Approx(0.02));
}

TEST_CASE("the emergency stop acts at once and stays latched") {
  for (std::uint64_t seed = 0; seed < cases(200); ++seed) {
    Draws draw(seed);
    Gate gate(random_model(draw));
    for (int i = 0; i < 50; ++i) gate(random_request(gate.model, draw));
    gate.state.estop = true;
    for (int i = 0; i < 50; ++i) {
      REQUIRE(gate(random_request(gate.model, draw)) == GateOutput{{}, Intervention::estop});
    }
    gate.state.estop = false;
    CHECK(speed(gate({0.5, 0.0, 0.0}).command) <= gate.model.limits.linear_acceleration * kPeriod * (1 + 1e-9));
  }
}

TEST_CASE("a turn takes speed from a base whose wheels roll as fast as they can, and keeps its arc") {
  for (const std::string& name : profile_names()) {
    const RobotProfile profile = load_profile(name);
    Gate gate(make_gate_model(profile));
    for (std::uint64_t seed = 0; seed < cases(200); ++seed) {
      Draws draw(seed);
      const Velocity request = within_limits(gate.model.limits, random_request(gate.model, draw));
      GateOutput output;
      for (int i = 0; i < 100; ++i) output = gate(request);
      const Velocity& v = output.command;
      for (const double turning : wheel_speeds(profile.body.wheels, v))
        CHECK(std::fabs(turning) * profile.body.wheels.radius <= profile.hardware_limits.linear * (1.0 + 1e-9));
      CHECK(v.omega * request.vx == doctest::Approx(v.vx * request.omega));
      if (profile.kinematics() == Kinematics::holonomic) CHECK(v == request);
    }
  }
}
