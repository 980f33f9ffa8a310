// Sensors that break: what a robot does about it.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "robot/faulty_port.hpp"
#include "robot/warnings.hpp"
#include "threewe/backend/registry.hpp"
#include "threewe/robot/robot.hpp"

using namespace threewe;
using namespace threewe::test;

namespace {

// A robot in the office, on its way, that something happens to.
struct Drive {
  explicit Drive(std::uint64_t seed) {
    backend::WorldOptions options;
    options.seed = seed;
    auto faulty = std::make_unique<WorldOfFaults>(backend::make_world("mock", options));
    port = &faulty->robot(0);
    world = std::make_unique<World>(std::move(faulty));
    robot = std::make_unique<Robot>(*world);
    motion = robot->move_to(4.0, 1.0, {.timeout = 60.0});
    robot->sleep(2.0);
  }
  std::uint16_t sensor(SensorType type) const {
    const auto& sensors = robot->runtime().features().sensors;
    const auto found = std::ranges::find(sensors, type, &SensorInfo::type);
    return static_cast<std::uint16_t>(found - sensors.begin());
  }
  const SensorHealth& health(SensorType type) const { return robot->health()[sensor(type)]; }
  double speed() const { return norm({robot->get_velocity().vx, robot->get_velocity().vy}); }

  Warnings warnings;
  FaultyPort* port = nullptr;
  std::unique_ptr<World> world;
  std::unique_ptr<Robot> robot;
  MotionHandle motion;
};

}  // namespace

TEST_CASE("a robot waits for a sensor that breaks, says which, and reaches its goal all the same") {
  struct Case {
    FaultKind kind;
    SensorType type;
    double size;
    SensorFault fault;
  };
  const std::vector<Case> cases = {{FaultKind::silent, SensorType::lidar, 0.0, SensorFault::silent},
                                   {FaultKind::frozen, SensorType::lidar, 0.0, SensorFault::frozen},
                                   {FaultKind::nan, SensorType::imu, 0.0, SensorFault::implausible},
                                   {FaultKind::stamps_back, SensorType::odometry, 2.0, SensorFault::wrong_stamps},
                                   {FaultKind::stamps_ahead, SensorType::imu, 2.0, SensorFault::wrong_stamps},
                                   {FaultKind::noise, SensorType::lidar, 5.0, SensorFault::noisy},
                                   {FaultKind::bias, SensorType::lidar, 0.2, SensorFault::shifted},
                                   {FaultKind::bias, SensorType::imu, 0.0873, SensorFault::contradicted},
                                   {FaultKind::delay, SensorType::lidar, 0.5, SensorFault::silent},
                                   {FaultKind::dropout, SensorType::lidar, 0.97, SensorFault::blind},
                                   {FaultKind::covered, SensorType::lidar, 1.0, SensorFault::blind},
                                   {FaultKind::slip, SensorType::odometry, 0.0, SensorFault::contradicted},
                                   {FaultKind::wheel_slip, SensorType::odometry, 0.0, SensorFault::contradicted},
                                   {FaultKind::wheel_blocked, SensorType::odometry, 0.0, SensorFault::contradicted}};
  std::uint64_t seed = 1000000;
  for (const Case& c : cases) {
    Drive d(seed++);
    const std::string kind = kFaultNames[static_cast<std::size_t>(c.kind)];
    CAPTURE(kind);
    CAPTURE(to_string(c.type));
    REQUIRE(d.speed() > 0.1);
    const Time now = d.world->now();
    d.port->break_with(
        {{.kind = c.kind, .sensor = d.sensor(c.type), .size = c.size, .from = now, .until = now + 3s, .wheel = 1}});
    std::optional<Time> noticed;
    while (d.world->now() < now + 3s) {
      d.world->tick();
      CHECK(is_finite(d.robot->runtime().commanded().command));
      if (!noticed && !d.health(c.type).ok()) {
        noticed = d.world->now();
        CHECK(d.health(c.type).fault == c.fault);
        CHECK(d.health(c.type).since == *noticed);
      }
    }
    REQUIRE(noticed);
    CHECK(*noticed - now <= (c.fault == SensorFault::contradicted ? 2s : 250ms));
    CHECK(d.warnings.mentioning("'" + d.health(c.type).name + "' is") > 0);
    const MoveResult result = d.robot->wait(d.motion);
    CHECK(result.success);
    CHECK(d.robot->simulation()->max_collision_speed() <= 0.05);
    const Pose2D truly = inverse(d.robot->simulation()->start_pose()) * d.robot->simulation()->true_pose();
    CHECK(distance(truly.position(), {4.0, 1.0}) <= 0.25);
  }
}

TEST_CASE("a robot goes on without a sensor that it does not need") {
  Drive d(1000100);
  const Time now = d.world->now();
  d.port->break_with({{.kind = FaultKind::silent, .sensor = d.sensor(SensorType::ultrasonic), .from = now}});
  d.robot->sleep(1.0);
  CHECK(d.health(SensorType::ultrasonic).fault == SensorFault::silent);
  CHECK_FALSE(d.health(SensorType::ultrasonic).needed);
  CHECK(d.warnings.mentioning("it does without") == 1);
  CHECK(d.robot->wait(d.motion).success);
}

TEST_CASE("health is part of what is saved, and everybody is sound after a reset") {
  Drive d(1000200);
  d.motion->cancel();
  const Time now = d.world->now();
  d.port->break_with({{.kind = FaultKind::silent, .sensor = d.sensor(SensorType::lidar), .from = now}});
  d.robot->sleep(1.0);
  CHECK_FALSE(d.health(SensorType::lidar).ok());
  d.port->break_with({});
  d.robot->simulation()->reset(1000201);
  d.robot->sleep(0.5);
  for (const SensorHealth& health : d.robot->health()) CHECK(health.ok());
}
