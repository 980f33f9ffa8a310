// What breaks, and what is left when it does: a result with a reason, a robot that stands still.
#include <doctest/doctest.h>

#include <cmath>

#include "robot/scripted_autonomy.hpp"
#include "robot/toy_world.hpp"
#include "robot/warnings.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/robot/robot.hpp"

using namespace threewe;
using namespace threewe::test;

namespace {

// A robot in the middle of a motion, and what must be true after its port failed.
struct Driving {
  Driving() : toy({"3we_standard_v2"}, restless()), robot(*toy.world), motion(robot.move_to(2.0, 0.0)) {
    robot.sleep(0.5);
  }

  void check_fault(const std::string& why) {
    const MoveResult result = robot.wait(motion);
    CHECK(result.reason == Reason::fault);
    CHECK(result.detail.find(why) != std::string::npos);
    CHECK_THROWS_AS(result.raise_for_failure(), HardwareError);
    CHECK(robot.runtime().fault() == result.detail);
    CHECK(warnings.mentioning(why) == 1);
    CHECK_THROWS_AS(robot.get_pose(), ConnectionError);
    CHECK_THROWS_AS(robot.set_velocity(0.1, 0.0, 0.0), ConnectionError);
    CHECK_THROWS_AS((void)robot.move_to(1.0, 0.0), ConnectionError);

    robot.sleep(0.3);  // time goes by, the robot stands still
    const Pose2D pose = toy.port().pose;
    robot.sleep(1.0);
    CHECK(toy.port().pose == pose);
  }

  Warnings warnings;
  Toy toy;
  Robot robot;
  MotionHandle motion;
};

}  // namespace

TEST_CASE("a port that throws from poll") {
  Driving d;
  d.toy.port().on_poll = [](Time) { throw std::runtime_error("the cable is loose"); };
  d.check_fault("the cable is loose");
  d.toy.port().on_poll = nullptr;
  d.robot.connect();
  CHECK(d.robot.runtime().fault().empty());
  d.robot.set_velocity(0.1, 0.0, 0.0);
  const double before = d.toy.port().pose.x;
  d.robot.sleep(0.4);
  CHECK(d.toy.port().pose.x > before);
}

TEST_CASE("a port that throws from command, also from the command that should stop it") {
  Driving d;
  d.toy.port().on_command = [](Time) { throw std::runtime_error("the motor is gone"); };
  d.check_fault("the motor is gone");
}

TEST_CASE("what is wrong with the way to a robot is warned of once, and again when it is something else") {
  const Warnings warnings;
  Toy toy;
  Robot robot(*toy.world);
  robot.connect();
  toy.port().wrong_link = "images are lost";
  robot.sleep(0.5);
  CHECK(warnings.mentioning("robot '3we_standard_v2': images are lost") == 1);
  toy.port().wrong_link = "all is lost";
  robot.sleep(0.5);
  CHECK(warnings.messages.size() == 2);
}

TEST_CASE("samples that break the contract") {
  struct Case {
    const char* message;
    std::function<void(std::vector<Sample>&)> spoil;
  };
  const std::vector<Case> cases = {
      {"names sensor 9", [](auto& samples) { samples.at(0).sensor = 9; }},
      {"another kind of data",
       [](auto& samples) {
         samples.at(0).data = BatteryState{};
         samples.at(0).sensor = ToyPort::kImu;
       }},
  };
  for (const Case& c : cases) {
    CAPTURE(c.message);
    Driving d;
    d.toy.port().on_samples = c.spoil;
    d.check_fault(c.message);
  }
}

TEST_CASE("readings that no sensor can make are used by nobody, and the robot waits until they are over") {
  struct Case {
    const char* sensor;
    const char* message;
    std::function<void(Sample&)> spoil;
  };
  const auto with = [](SampleData data) { return [data](Sample& sample) { sample.data = data; }; };
  const std::vector<Case> cases = {
      {"imu", "must be finite", with(IMUData{{NAN, 0.0, 0.0}, {}})},
      {"odometry", "pose is 1000000000000; it must be within", with(Odometry{{1e12, 0.0, 0.0}, {}})},
      {"imu", "angular_velocity is 1e+300; it must be within", with(IMUData{{1e300, 0.0, 0.0}, {}})},
      {"lidar", "[7] is nan", [](Sample& sample) { std::get<LaserScan>(sample.data).ranges[7] = NAN; }},
      {"odometry", "stamped wrongly", [](Sample& sample) { sample.measured = 1h; }},
      {"imu", "stamped wrongly", [](Sample& sample) { sample.measured -= 1s; }},
  };
  for (const Case& c : cases) {
    CAPTURE(c.message);
    Driving d;
    const auto& sensors = d.robot.runtime().features().sensors;
    d.toy.port().on_samples = [&](std::vector<Sample>& samples) {
      for (Sample& sample : samples) {
        if (sensors[sample.sensor].name == c.sensor) c.spoil(sample);
      }
    };
    d.robot.sleep(0.5);
    CHECK(d.toy.port().commands.back() == Velocity{});
    CHECK_FALSE(d.motion->done());
    CHECK(d.warnings.mentioning(c.message) == 1);
    for (const SensorHealth& health : d.robot.health()) CHECK(health.ok() == (health.name != c.sensor));
    CHECK(std::isfinite(d.robot.get_pose().x));

    d.toy.port().on_samples = nullptr;
    d.robot.sleep(0.6);
    CHECK(d.toy.port().commands.back().vx > 0.0);
    CHECK(d.warnings.mentioning(std::string(c.sensor).append("' is ok again")) == 1);
    d.motion->cancel();
  }
}

TEST_CASE("initial poses that no map can hold, or of no robot, are refused") {
  CHECK_THROWS_AS(Robot({.initial_pose = Pose2D{1e9, 0.0, 0.0}}), ContractError);
  World::Options options;
  options.initial_poses = std::vector<Pose2D>(options.robots.size() + 1);
  CHECK_THROWS_AS(World{options}, ConfigError);
}

TEST_CASE("a world that cannot advance fails every robot and says so until it begins anew") {
  Warnings warnings;
  Toy toy({"3we_standard_v2", "3we_standard_v2"}, restless());
  Robot first(*toy.world, 0);
  Robot second(*toy.world, 1);
  const MotionHandle one = first.move_to(2.0, 0.0);
  const MotionHandle other = second.move_to(2.0, 1.0);
  const WaitHandle sleep = toy.world->sleep(10s);
  toy.backend->on_advance = [](Time t) {
    if (t > 1s) throw std::runtime_error("the simulator crashed");
  };
  CHECK_THROWS_WITH_AS(toy.world->wait(sleep), "the world stopped: the simulator crashed", ConnectionError);
  CHECK(one->result().reason == Reason::fault);
  CHECK(other->result().reason == Reason::fault);
  CHECK_THROWS_AS(toy.world->tick(), ConnectionError);
  CHECK(warnings.mentioning("the simulator crashed") == 2);
}

TEST_CASE("one robot fails, the others go on") {
  Warnings warnings;
  Toy toy({"3we_standard_v2", "3we_standard_v2"}, restless());
  Robot first(*toy.world, 0);
  Robot second(*toy.world, 1);
  const MotionHandle one = first.move_to(2.0, 0.0);
  const MotionHandle other = second.move_to(2.0, 1.0, {.timeout = 3.0});
  toy.port(0).on_poll = [](Time) { throw std::runtime_error("lost"); };
  CHECK(second.wait(other).reason == Reason::timeout);
  CHECK(one->result().reason == Reason::fault);
  CHECK(toy.port(1).pose.x > 0.7);
}

TEST_CASE("a navigator that throws") {
  Warnings warnings;
  Toy toy({"3we_standard_v2"}, scripted([](const auto&) -> nav::Decision { throw std::runtime_error("no service"); }));
  Robot robot(*toy.world);
  const MoveResult result = robot.wait(robot.move_to(2.0, 0.0));
  CHECK(result.reason == Reason::fault);
  CHECK(result.detail == "no service");
}

TEST_CASE("time that connecting takes is no silence of sensors") {
  const Warnings warnings;
  auto owned = std::make_unique<ToyWorld>();
  ToyWorld& toy = *owned;
  ToyPort& port = toy.robot(0);
  port.run_by_itself();
  port.on_connect = [&toy] { toy.pass(3s); };  // as a robot that has to be found first
  port.silent = {true, true, true, true};      // it begins to deliver once it is connected
  World world(std::move(owned));
  world.robot(0).connect();
  world.tick();
  CHECK(world.now() >= 3s);
  CHECK(warnings.mentioning("silent") == 0);
  for (int i = 0; i < 100; ++i) world.tick();  // which are silent indeed
  CHECK(warnings.mentioning("silent") > 0);
}

TEST_CASE("first samples are waited for however long connecting takes") {
  auto owned = std::make_unique<ToyWorld>();
  ToyWorld& toy = *owned;
  toy.robot(0).run_by_itself();
  toy.robot(0).on_connect = [&toy] { toy.pass(3s); };
  World world(std::move(owned));
  world.robot(0).connect();
  world.settle();
  CHECK(world.now() >= 3s);
  CHECK(world.robot(0).battery().charge == 0.9);
}

TEST_CASE("a sensor that falls silent stops the robot, and in the end the motion") {
  for (const auto sensor : {ToyPort::kLidar, ToyPort::kOdometry}) {
    Driving d;
    const Time silent_from = d.toy.world->now();
    d.toy.port().silent[sensor] = true;
    d.robot.sleep(0.4);
    CHECK(d.toy.port().commands.back() == Velocity{});
    CHECK_FALSE(d.motion->done());
    const MoveResult result = d.robot.wait(d.motion);
    CHECK(result.reason == Reason::fault);
    CHECK(result.detail.find(sensor == ToyPort::kLidar ? "'lidar'" : "'odometry'") != std::string::npos);
    CHECK(to_seconds(d.toy.world->now() - silent_from) <= 10.3);
    // the port is in order, so that the robot is, once the sensor returns
    CHECK(d.robot.runtime().fault().empty());
    d.toy.port().silent[sensor] = false;
    d.robot.sleep(0.6);
    d.robot.set_velocity(0.1, 0.0, 0.0);
    d.robot.sleep(0.1);
    CHECK(d.toy.port().commands.back().vx > 0.0);
  }
}

TEST_CASE("a robot that was out of reach does not start again by itself") {
  Driving d;
  auto& silent = d.toy.port().silent;
  silent.assign(silent.size(), true);
  const MoveResult result = d.robot.wait(d.motion);
  CHECK(result.reason == Reason::fault);
  CHECK(result.detail.find("out of reach") != std::string::npos);
  silent.assign(silent.size(), false);
  d.robot.sleep(1.0);
  d.robot.set_velocity(0.1, 0.0, 0.0, 60.0);
  d.robot.sleep(0.2);
  CHECK(d.toy.port().commands.back().vx > 0.0);

  silent.assign(silent.size(), true);
  d.robot.sleep(1.0);
  silent.assign(silent.size(), false);
  for (int i = 0; i < 10; ++i) {
    d.robot.sleep(0.2);
    CHECK(d.toy.port().commands.back() == Velocity{});
  }
  CHECK(d.warnings.mentioning("out of reach") == 1);
  d.robot.set_velocity(0.1, 0.0, 0.0);
  d.robot.sleep(0.1);
  CHECK(d.toy.port().commands.back().vx > 0.0);
}

TEST_CASE("a runtime that is gone leaves a robot that stands still") {
  ToyWorld backend;
  ToyPort& port = backend.robot(0);
  port.connect();
  port.command({0.3, 0.0, 0.0}, 200ms);
  backend.advance_to(1s);
  CHECK(port.pose.x == doctest::Approx(0.06));
}

TEST_CASE("a motion ends with its robot, and its handle tells so") {
  MotionHandle motion;
  {
    Toy toy({"3we_standard_v2"}, restless());
    Robot robot(*toy.world);
    motion = robot.move_to(2.0, 0.0);
    robot.sleep(0.5);
  }
  REQUIRE(motion->done());
  CHECK(motion->result().reason == Reason::cancelled);
  CHECK(motion->result().detail == "the robot is gone");
  CHECK(motion->result().distance > 0.0);
  motion->cancel();  // does nothing
}
