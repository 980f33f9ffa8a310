// One robot: what may be asked of it, who owns it, how commands reach the port, how motions end.
#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/exact.hpp"
#include "robot/goals.hpp"
#include "robot/scripted_autonomy.hpp"
#include "robot/toy_world.hpp"
#include "robot/warnings.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/robot/robot.hpp"

using namespace threewe;
using namespace threewe::test;

namespace {

const double kNaN = std::nan("");
constexpr double kInfinity = std::numeric_limits<double>::infinity();

double speed(const Velocity& v) { return std::hypot(v.vx, v.vy); }

}  // namespace

TEST_CASE("nothing can be asked of a robot that is not connected") {
  Toy toy;
  Runtime& robot = toy.world->robot(0);
  const auto refuses_all = [&] {
    CHECK_THROWS_AS(robot.lidar_scan(), ConnectionError);
    CHECK_THROWS_AS(robot.pose(), ConnectionError);
    CHECK_THROWS_AS(robot.map(), ConnectionError);
    CHECK_THROWS_AS(robot.transform("map", "base"), ConnectionError);
    CHECK_THROWS_AS(robot.ready(), ConnectionError);
    CHECK_THROWS_AS(robot.set_velocity({}, 1s), ConnectionError);
    CHECK_THROWS_AS(robot.execute_action({}, 20ms), ConnectionError);
    CHECK_THROWS_AS(robot.start(nav::Rotate{1.0}), ConnectionError);
  };
  refuses_all();
  robot.connect();
  toy.world->settle();
  CHECK(robot.lidar_scan().ranges.size() == 360);
  robot.disconnect();
  refuses_all();
  robot.stop();  // always allowed
  robot.estop();
  robot.release_estop();
}

TEST_CASE("a robot is ready when every sensor has delivered, at the latest after 2 s") {
  Toy toy;
  Runtime& robot = toy.world->robot(0);
  robot.connect();
  CHECK_THROWS_WITH_AS(robot.battery(), "sensor 'battery' has not delivered anything yet", HardwareError);
  toy.world->wait(robot.ready());
  CHECK(toy.world->now() == 100ms);
  CHECK(robot.battery().charge == 0.9);
  CHECK(robot.ready()->done());

  Toy mute;
  mute.port().silent[ToyPort::kImu] = true;
  mute.world->robot(0).connect();
  mute.world->settle();
  CHECK(mute.world->now() == 2s);
  CHECK_THROWS_WITH_AS(mute.world->robot(0).imu(), "sensor 'imu' has not delivered anything yet", HardwareError);
}

TEST_CASE("input that makes no sense is refused and changes nothing") {
  Toy toy({"turtlebot_like"});
  Robot robot(*toy.world);
  for (const double bad : {kNaN, kInfinity, -kInfinity}) {
    CHECK_THROWS_AS(robot.set_velocity(bad, 0.0, 0.0), ContractError);
    CHECK_THROWS_AS(robot.set_velocity(0.0, bad, 0.0), ContractError);
    CHECK_THROWS_AS(robot.set_velocity(0.0, 0.0, bad), ContractError);
    CHECK_THROWS_AS(robot.set_velocity(0.1, 0.0, 0.0, bad), ContractError);
    CHECK_THROWS_AS(robot.execute_action({bad, 0.0, 0.0}), ContractError);
    CHECK_THROWS_AS((void)robot.move_to(bad, 0.0), ContractError);
    CHECK_THROWS_AS((void)robot.move_to(0.0, bad), ContractError);
    CHECK_THROWS_AS((void)robot.move_to(0.0, 0.0, {.theta = bad}), ContractError);
    CHECK_THROWS_AS((void)robot.move_to(0.0, 0.0, {.tolerance = bad}), ContractError);
    CHECK_THROWS_AS((void)robot.move_to(0.0, 0.0, {.timeout = bad}), ContractError);
    CHECK_THROWS_AS((void)robot.move_to(0.0, 0.0, {.angle_tolerance = bad}), ContractError);
    CHECK_THROWS_AS((void)robot.rotate(bad), ContractError);
    CHECK_THROWS_AS((void)robot.rotate(1.0, bad), ContractError);
    CHECK_THROWS_AS((void)robot.move_forward(bad), ContractError);
    CHECK_THROWS_AS((void)robot.move_forward(1.0, bad), ContractError);
    CHECK_THROWS_AS((void)robot.follow_path({{0.0, 0.0}, {bad, 1.0}}), ContractError);
    CHECK_THROWS_AS(robot.sleep(bad), ContractError);
  }
  CHECK_THROWS_AS((void)robot.follow_path({}), ContractError);
  CHECK_THROWS_AS((void)robot.move_to(1.0, 0.0, {.tolerance = 0.0}), ContractError);
  CHECK_THROWS_AS((void)robot.move_to(1.0, 0.0, {.timeout = -1.0}), ContractError);
  CHECK_THROWS_WITH_AS((void)robot.move_to(1.0, 0.0, {.frame = "bass"}), "unknown frame 'bass'; did you mean 'base'?",
                       ContractError);
  CHECK_THROWS_AS(robot.set_velocity(0.1, 0.0, 0.0, 0.0), ContractError);
  CHECK_THROWS_AS(robot.set_velocity(0.1, 0.1, 0.0), ContractError);  // no vy on a differential base
  CHECK_THROWS_AS(robot.execute_action({0.0, 0.5, 0.0}), ContractError);
  robot.sleep(0.5);
  CHECK(toy.port().pose == Pose2D{});
  CHECK(robot.runtime().motion() == nullptr);
}

TEST_CASE("a command takes effect in the very next tick, and every tick renews it") {
  Toy toy;
  Robot robot(*toy.world);
  const std::size_t before = toy.port().commands.size();
  robot.set_velocity(0.02, 0.0, 0.0, 0.1);
  for (int i = 0; i < 5; ++i) toy.world->tick();
  CHECK(toy.port().commands.size() == before + 5);
  for (std::size_t i = before; i < toy.port().commands.size(); ++i) CHECK(toy.port().commands[i].vx == 0.02);
  toy.world->tick();
  CHECK(toy.port().commands.back() == Velocity{});
}

TEST_CASE("a velocity beyond all measure drives at the limit, in its direction") {
  Toy toy;
  Robot robot(*toy.world);
  robot.set_velocity(-1e308, 1e308, -1e308, 1.0);
  robot.sleep(1.0);
  const Limits& limits = robot.runtime().profile().operating_limits;
  const Velocity driven = toy.port().commands.back();
  CHECK(driven.vx == doctest::Approx(-limits.linear / std::sqrt(2.0)));
  CHECK(driven.vy == doctest::Approx(limits.linear / std::sqrt(2.0)));
  CHECK(driven.omega == doctest::Approx(-limits.angular));
}

TEST_CASE("a velocity that is not renewed stops the robot and warns once") {
  const Warnings warnings;
  Toy toy;
  Robot robot(*toy.world);
  for (int i = 0; i < 3; ++i) {
    robot.set_velocity(0.3, 0.0, 0.0, 0.2);
    robot.sleep(1.0);
    CHECK(toy.port().commands.back() == Velocity{});
  }
  CHECK(warnings.messages.size() == 1);
  CHECK(warnings.mentioning("set_velocity") == 1);
}

TEST_CASE("stopping, and control steps that end, are no reason to warn") {
  const Warnings warnings;
  Toy toy;
  Robot robot(*toy.world);
  robot.set_velocity(0.3, 0.0, 0.0);
  robot.sleep(0.2);
  robot.stop();
  robot.sleep(1.0);
  robot.execute_action({1.0, 0.0, 0.0});
  robot.sleep(1.0);
  CHECK(warnings.messages.empty());
}

TEST_CASE("a loop that only reads is told once that time stands still") {
  const Warnings warnings;
  Toy toy;
  Robot robot(*toy.world);
  for (int i = 0; i < 999; ++i) (void)robot.get_pose();
  CHECK(warnings.messages.empty());
  for (int i = 0; i < 5000; ++i) (void)robot.get_pose();
  CHECK(warnings.messages.size() == 1);
  CHECK(warnings.mentioning("robot.sleep") == 1);
}

TEST_CASE("a loop that reads and waits is not") {
  const Warnings warnings;
  Toy toy;
  Robot robot(*toy.world);
  for (int i = 0; i < 2000; ++i) {
    (void)robot.get_pose();
    robot.sleep(0.02);
  }
  CHECK(warnings.messages.empty());
}

TEST_CASE("a control step is scaled to the limits, clamped, and tells what was executed") {
  Toy toy;
  Robot robot(*toy.world);
  const Limits& limits = robot.runtime().profile().operating_limits;
  const Time start = toy.world->now();
  Velocity executed;
  for (int i = 0; i < 100; ++i) executed = robot.execute_action({0.5, 0.0, -7.0});
  CHECK(toy.world->now() == start + 100 * kControlPeriod);
  CHECK(executed.vx == doctest::Approx(0.5 * limits.linear));
  CHECK(executed.omega == doctest::Approx(-limits.angular));
  CHECK(toy.port().commands.back() == executed);
}

TEST_CASE("one owner at a time") {
  Toy toy({"3we_standard_v2"}, restless());
  Robot robot(*toy.world);
  const MotionHandle motion = robot.move_to(2.0, 0.0);
  CHECK_THROWS_AS(robot.set_velocity(0.1, 0.0, 0.0), SafetyError);
  CHECK_THROWS_AS(robot.execute_action({0.1, 0.0, 0.0}), SafetyError);
  CHECK_THROWS_AS((void)robot.rotate(1.0), SafetyError);
  CHECK_FALSE(motion->done());
  CHECK_THROWS_AS(motion->result(), ContractError);

  robot.stop();
  CHECK(motion->result().reason == Reason::cancelled);
  robot.set_velocity(0.1, 0.0, 0.0);
  (void)robot.rotate(1.0);  // a motion takes over from a velocity
}

TEST_CASE("cancelling commands zero within one period, and stand-still follows") {
  Toy toy({"3we_standard_v2"}, restless());
  Robot robot(*toy.world);
  const MotionHandle motion = robot.move_to(2.0, 0.0);
  robot.sleep(1.0);
  CHECK(speed(toy.port().commands.back()) == doctest::Approx(0.3));
  motion->cancel();
  CHECK(motion->result().reason == Reason::cancelled);
  CHECK_THROWS_AS(motion->result().raise_for_failure(), NavigationError);
  CHECK(toy.world->take_finished() == std::vector<WaitHandle>{motion});
  toy.world->tick();
  CHECK(robot.runtime().requested() == Velocity{});
  CHECK(speed(toy.port().commands.back()) < 0.3);
  robot.sleep(0.25);
  CHECK(toy.port().commands.back() == Velocity{});
  motion->cancel();  // does nothing
}

TEST_CASE("whoever asks for creep mode drives slowly, and keeps the gate's margin of a wall ahead") {
  const auto stands_at = [](const char* hardware, bool creep_mode, bool by_motion) {
    Toy toy({hardware}, scripted([creep_mode](const auto&) {
              return nav::Decision{{0.3, 0.0, 0.0}, Reason::running, "", creep_mode};
            }));
    Robot robot(*toy.world);
    const MotionHandle motion = by_motion ? robot.move_to(3.0, 0.0) : nullptr;
    if (!by_motion) robot.runtime().set_velocity({0.3, 0.0, 0.0}, 200s, creep_mode);
    double fastest = 0.0;
    for (int i = 0; i < 1100; ++i) {
      robot.sleep(0.1);
      fastest = std::max(fastest, speed(toy.port().commands.back()));
    }
    CAPTURE(hardware);
    CHECK((creep_mode ? fastest <= 0.04 + 1e-9 : fastest > 0.05));
    return toy.port().pose.x;
  };
  for (const bool by_motion : {false, true}) {
    CHECK(stands_at("3we_standard_v2", true, by_motion) ==
          doctest::Approx(stands_at("3we_standard_v2", false, by_motion)).epsilon(0.001));
    CHECK(stands_at("blind", true, by_motion) < 4.5);
  }
}

TEST_CASE("a motion ends when its time is over") {
  Toy toy({"3we_standard_v2"}, scripted([](const auto&) { return nav::Decision{}; }));
  Robot robot(*toy.world);
  const Time start = toy.world->now();
  const MoveResult result = robot.wait(robot.move_to(2.0, 0.0, {.timeout = 3.0}));
  CHECK_FALSE(result.success);
  CHECK(result.reason == Reason::timeout);
  CHECK(result.duration == doctest::Approx(3.0));
  CHECK(result.distance_to_goal == doctest::Approx(2.0));
  CHECK(toy.world->now() == start + 3s);
  CHECK_THROWS_AS(result.raise_for_failure(), threewe::TimeoutError);
}

TEST_CASE("a motion without a time limit goes on for as long as its navigator does") {
  Toy toy({"3we_standard_v2"}, scripted([](const nav::Observation& seen) {
            return nav::Decision{{}, seen.now < 2000s ? Reason::running : Reason::no_path, ""};
          }));
  Robot robot(*toy.world);
  const MoveResult result = robot.wait(robot.move_to(0.5, 0.0));
  CHECK(result.reason == Reason::no_path);
  CHECK(result.duration > 1999.0);
}

TEST_CASE("a motion that its navigator ends is over when the robot stands") {
  for (const Reason reason : {Reason::reached, Reason::no_path}) {
    Toy toy({"3we_standard_v2"}, scripted([reason](const nav::Observation& seen) {
              const bool there = seen.pose.map_from_base().x > 0.3;
              return nav::Decision{{0.4, 0.0, 0.0}, there ? reason : Reason::running, ""};
            }));
    Robot robot(*toy.world);
    const MoveResult result = robot.wait(robot.move_to(0.4, 0.0));
    CHECK(result.reason == reason);
    CHECK(toy.port().commands.back() == Velocity{});
    CHECK(robot.runtime().pose().velocity.vx < 0.01);
  }
}

TEST_CASE("a source steers in place of the navigator, and says how it ends") {
  for (const Reason reason : {Reason::reached, Reason::starved, Reason::policy_error, Reason::fault}) {
    Toy toy({"3we_standard_v2"}, restless());
    Robot robot(*toy.world);
    Runtime& runtime = robot.runtime();
    std::vector<Time> asked;
    const MotionHandle motion = runtime.drive([&](Time now) {
      asked.push_back(now);
      return nav::Decision{{0.3, 0.1, 0.0}, asked.size() > 50 ? reason : Reason::running, "so it is"};
    });
    CHECK_THROWS_AS(robot.set_velocity(0.1, 0.0, 0.0), SafetyError);
    CHECK_THROWS_AS((void)robot.move_to(1.0, 0.0), SafetyError);
    CHECK_THROWS_AS((void)runtime.drive([](Time) { return nav::Decision{}; }), SafetyError);
    robot.sleep(0.5);
    CHECK(toy.port().commands.back().vx == doctest::Approx(0.3));
    CHECK(runtime.path().empty());
    CHECK(motion->progress().distance_driven > 0.05);
    const MoveResult result = robot.wait(motion);
    CHECK(result.reason == reason);
    CHECK(result.success == (reason == Reason::reached));
    CHECK(result.detail == "so it is");
    CHECK(toy.port().commands.back() == Velocity{});
    for (std::size_t i = 1; i < asked.size(); ++i) CHECK(asked[i] - asked[i - 1] == kControlPeriod);
    CHECK(asked.size() == 51);
    if (!result.success) CHECK_THROWS(result.raise_for_failure());
    robot.set_velocity(0.1, 0.0, 0.0);  // usable at once
  }
}

TEST_CASE("what ends every motion ends one that a source steers") {
  const auto ahead = [](Time) { return nav::Decision{{0.3, 0.0, 0.0}, Reason::running, ""}; };
  const auto ended_by = [&](const std::function<void(Toy&, Robot&)>& act) {
    Toy toy;
    Robot robot(*toy.world);
    const MotionHandle motion = robot.runtime().drive(ahead, 2s);
    robot.sleep(1.0);
    act(toy, robot);
    robot.sleep(1.5);
    return motion->result().reason;
  };
  CHECK(ended_by([](Toy&, Robot&) {}) == Reason::timeout);
  CHECK(ended_by([](Toy&, Robot& robot) { robot.stop(); }) == Reason::cancelled);
  CHECK(ended_by([](Toy&, Robot& robot) { robot.emergency_stop(); }) == Reason::estop);
  CHECK(ended_by([](Toy& toy, Robot&) { toy.port().on_poll = [](Time) { throw HardwareError("broken"); }; }) ==
        Reason::fault);
}

TEST_CASE("a source that fails stops the robot and is named") {
  const std::vector<VelocitySource> bad = {
      [](Time) -> nav::Decision { throw ContractError("no idea"); },
      [](Time) { return nav::Decision{{kNaN, 0.0, 0.0}, Reason::running, ""}; },
      [](Time) { return nav::Decision{{0.0, 0.0, kInfinity}, Reason::running, ""}; },
  };
  for (const VelocitySource& source : bad) {
    Toy toy;
    Robot robot(*toy.world);
    const Time begin = toy.world->now();
    const MotionHandle motion = robot.runtime().drive(
        [&](Time now) { return now < begin + 1s ? nav::Decision{{0.4, 0.0, 0.0}, Reason::running, ""} : source(now); });
    const MoveResult result = robot.wait(motion);
    CHECK(result.reason == Reason::policy_error);
    CHECK_FALSE(result.detail.empty());
    CHECK(toy.world->now() - begin < 1250ms);
    CHECK(toy.port().commands.back() == Velocity{});
    CHECK_THROWS_AS(result.raise_for_failure(), NavigationError);
  }
  Toy toy({"turtlebot_like"});
  Robot robot(*toy.world);
  const auto sideways = [](Time) { return nav::Decision{{0.0, 0.1, 0.0}, Reason::running, ""}; };
  CHECK(robot.wait(robot.runtime().drive(sideways)).reason == Reason::policy_error);
}

TEST_CASE("zones hold for what a source wants") {
  const auto square = [](double x, double size) {
    return std::vector<Vec2>{{x, -size}, {x + 2.0 * size, -size}, {x + 2.0 * size, size}, {x, size}};
  };
  const auto ahead = [](Time) { return nav::Decision{{0.4, 0.0, 0.0}, Reason::running, ""}; };
  {
    Toy toy;
    Robot robot(*toy.world);
    robot.set_zones({{square(1.0, 0.5), {}}});
    CHECK(robot.wait(robot.runtime().drive(ahead, 10s)).reason == Reason::timeout);
    const double radius = robot.runtime().profile().body.footprint.circumscribed_radius();
    CHECK(toy.port().pose.x > 0.9 - radius);
    CHECK(toy.port().pose.x < 1.0 - radius);
    // away from it, and along it
    (void)robot.wait(robot.runtime().drive([](Time) { return nav::Decision{{-0.3, 0.0, 0.0}}; }, 1s));
    CHECK(toy.port().pose.x < 0.7);
  }
  Toy toy;
  Robot robot(*toy.world);
  robot.set_zones({{square(1.0, 0.5), 0.1}});
  const MotionHandle motion = robot.runtime().drive(ahead, 15s);
  double fastest_inside = 0.0;
  while (!motion->done()) {
    toy.world->tick();
    if (toy.port().pose.x > 0.9 && toy.port().pose.x < 2.1)
      fastest_inside = std::max(fastest_inside, speed(toy.port().commands.back()));
  }
  CHECK(fastest_inside == doctest::Approx(0.1).epsilon(0.05));
  CHECK(toy.port().pose.x > 1.5);
}

TEST_CASE("who is not within the tolerance wherever the true position may be has not reached the goal") {
  const auto drive = [](double goal, double tolerance) {
    Toy toy({"3we_standard_v2"}, scripted([](const auto&) { return nav::Decision{{}, Reason::reached, ""}; }));
    Robot robot(*toy.world);
    robot.sleep(1.0);
    return robot.wait(robot.move_to(goal, 0.0, {.tolerance = tolerance}));
  };
  const MoveResult there = drive(0.01, 0.1);
  CHECK(there.reason == Reason::reached);
  CHECK(there.position_uncertainty > 0.0);
  CHECK(there.position_uncertainty < 0.09);
  CHECK(drive(2.0, 0.1).reason == Reason::uncertain);
  const MoveResult known_too_badly = drive(0.01, 0.01 + 0.9 * there.position_uncertainty);
  CHECK(known_too_badly.reason == Reason::uncertain);
  CHECK(known_too_badly.detail.find("may be off by") != std::string::npos);
  CHECK_THROWS_AS(known_too_badly.raise_for_failure(), NavigationError);
}

TEST_CASE("a motion ends where the battery is empty") {
  Toy toy({"3we_standard_v2"}, restless());
  toy.port().on_samples = [&](std::vector<Sample>& samples) {
    if (toy.world->now() < 1s) return;
    for (Sample& sample : samples) {
      if (auto* battery = std::get_if<BatteryState>(&sample.data)) battery->charge = 0.0;
    }
  };
  Robot robot(*toy.world);
  const MoveResult result = robot.wait(robot.move_to(2.0, 0.0));
  CHECK(result.reason == Reason::fault);
  CHECK(result.detail == "the battery is empty");
}

TEST_CASE("every reason a navigator gives becomes a result") {
  for (const Reason reason : {Reason::reached, Reason::no_path, Reason::blocked, Reason::lost}) {
    Toy toy({"3we_standard_v2"}, scripted([reason](const auto&) { return nav::Decision{{}, reason, "so it is"}; }));
    Robot robot(*toy.world);
    const MoveResult result = robot.wait(robot.move_to(0.0, 0.0));
    CHECK(result.reason == reason);
    CHECK(result.success == (reason == Reason::reached));
    CHECK(result.detail == "so it is");
    if (result.success) {
      CHECK_NOTHROW(result.raise_for_failure());
    } else {
      CHECK_THROWS_AS(result.raise_for_failure(), NavigationError);
    }
  }
}

TEST_CASE("the emergency stop ends a motion, acts at once, and stays until released") {
  Toy toy({"3we_standard_v2"}, restless());
  Robot robot(*toy.world);
  const MotionHandle motion = robot.move_to(2.0, 0.0);
  robot.sleep(1.0);
  robot.emergency_stop();
  CHECK(motion->result().reason == Reason::estop);
  CHECK_THROWS_AS(motion->result().raise_for_failure(), EmergencyStopError);
  CHECK(toy.port().commands.back() == Velocity{});  // before the next tick
  CHECK_THROWS_AS((void)robot.move_to(1.0, 0.0), EmergencyStopError);
  CHECK_THROWS_AS(robot.set_velocity(0.1, 0.0, 0.0), EmergencyStopError);
  CHECK_THROWS_AS(robot.execute_action({0.1, 0.0, 0.0}), EmergencyStopError);
  robot.sleep(1.0);
  CHECK(robot.runtime().commanded() == safety::GateOutput{{}, safety::Intervention::estop});
  robot.release_emergency_stop();
  robot.set_velocity(0.1, 0.0, 0.0);
  robot.sleep(0.2);
  CHECK(toy.port().commands.back().vx > 0.0);
}

TEST_CASE("the emergency stop stays latched over a new connection") {
  Toy toy;
  Robot robot(*toy.world);
  robot.emergency_stop();
  robot.disconnect();
  robot.connect();
  CHECK_THROWS_AS(robot.set_velocity(0.1, 0.0, 0.0), EmergencyStopError);
}

TEST_CASE("disconnecting ends a motion and stops the robot") {
  Toy toy({"3we_standard_v2"}, restless());
  Robot robot(*toy.world);
  const MotionHandle motion = robot.move_to(2.0, 0.0);
  robot.sleep(0.5);
  robot.disconnect();
  CHECK(motion->result().reason == Reason::cancelled);
  CHECK(toy.port().commands.back() == Velocity{});
}

TEST_CASE("a robot stays where it was made, for others refer to it") {
  static_assert(!std::is_move_constructible_v<Robot>);
  static_assert(!std::is_move_assignable_v<Robot>);
  const auto make = [] { return Robot({.scene = "corridor_v1", .noise = NoiseLevel::ideal}); };  // needs no move
  Robot robot = make();
  CHECK(robot.wait(robot.move_forward(0.2)).success);
}

TEST_CASE("a world disconnects all of its robots") {
  Toy toy({"3we_standard_v2", "3we_standard_v2"}, restless());
  Robot first(*toy.world, 0);
  Robot second(*toy.world, 1);
  const MotionHandle motion = second.move_to(2.0, 0.0);
  first.set_velocity(0.3, 0.0, 0.0);
  first.sleep(0.2);
  toy.world->disconnect();
  CHECK(motion->result().reason == Reason::cancelled);
  for (const std::size_t i : {0U, 1U}) {
    CHECK(toy.port(i).commands.back() == Velocity{});
    CHECK_FALSE(toy.world->robot(i).connected());
  }
}

TEST_CASE("frames fit together") {
  Toy toy({"3we_standard_v2"}, {}, {{5.0, 6.0, 1.5}});
  Robot robot(*toy.world);
  robot.set_velocity(0.3, 0.0, 0.5, 2.0);
  robot.sleep(2.0);
  const Pose2D map_from_base = robot.get_transform("map", "base");
  CHECK(map_from_base.x == doctest::Approx(robot.get_pose().x));
  CHECK(map_from_base.y == doctest::Approx(robot.get_pose().y));
  const Pose2D chained = robot.get_transform("map", "odom") * robot.get_transform("odom", "base");
  CHECK(distance(chained.position(), map_from_base.position()) < 1e-12);
  CHECK(robot.get_transform("base", "lidar").x == doctest::Approx(0.04));
  CHECK(robot.get_transform("lidar", "base").x == doctest::Approx(-0.04));
  CHECK(robot.get_transform("imu", "imu") == Pose2D{});
  CHECK_THROWS_WITH_AS(robot.get_transform("lidr", "base"), "unknown frame 'lidr'; did you mean 'lidar'?",
                       ContractError);
}

TEST_CASE("the map frame is where the robot starts, unless it is told where that is") {
  for (const Pose2D& start : {Pose2D{}, Pose2D{3.0, -2.0, 1.0}}) {
    Toy toy({"3we_standard_v2"}, {}, {start});
    Robot robot(*toy.world);
    CHECK(distance(robot.get_pose().position(), start.position()) < 0.01);
    const Vec2 ahead = start * Vec2{1.0, 0.0};
    CHECK(robot.wait(robot.move_to(ahead.x, ahead.y, {.tolerance = 0.1})).success);
    CHECK(distance(toy.port().pose.position(), {1.0, 0.0}) < 0.15);
  }
}

TEST_CASE("goals in other frames") {
  Toy toy({"3we_standard_v2"}, {}, {{3.0, -2.0, 1.0}});
  Robot robot(*toy.world);
  CHECK(robot.wait(robot.move_to(0.0, 1.0, {.frame = "odom", .tolerance = 0.1})).success);
  CHECK(distance(toy.port().pose.position(), {0.0, 1.0}) < 0.15);
  const Vec2 right = toy.port().pose * Vec2{0.0, -0.5};
  CHECK(robot.wait(robot.move_to(0.0, -0.5, {.frame = "base", .tolerance = 0.1})).success);
  CHECK(distance(toy.port().pose.position(), right) < 0.15);
}

TEST_CASE("the robot drives as told and knows it") {
  Toy toy;
  Robot robot(*toy.world);
  const MoveResult ahead = robot.wait(robot.move_forward(1.0));
  CHECK(ahead.success);
  CHECK(ahead.distance == doctest::Approx(1.0).epsilon(0.1));
  CHECK(toy.port().pose.x == doctest::Approx(1.0).epsilon(0.1));
  CHECK(robot.wait(robot.rotate(exact::kPi / 2)).success);
  CHECK(toy.port().pose.theta == doctest::Approx(exact::kPi / 2).epsilon(0.1));
  const Vec2 here = toy.port().pose.position();
  CHECK(robot.wait(robot.follow_path({here + Vec2{0.0, 0.5}, here + Vec2{0.5, 1.0}})).success);
  CHECK(distance(toy.port().pose.position(), here + Vec2{0.5, 1.0}) < 0.3);
}

TEST_CASE("the room's wall stops a robot that is told to drive on") {
  Toy toy;
  Robot robot(*toy.world);
  for (int i = 0; i < 1000; ++i) robot.execute_action({1.0, 0.0, 0.0});
  CHECK(toy.port().pose.x + 0.125 < ToyPort::kRoom);
  CHECK(toy.port().pose.x + 0.125 > ToyPort::kRoom - 0.1);
  CHECK(robot.runtime().commanded().intervention == safety::Intervention::stopped_for_obstacle);
}

TEST_CASE("a robot without a lidar neither maps nor explores, but drives") {
  Toy toy({"blind"});
  Robot robot(*toy.world);
  CHECK_THROWS_WITH_AS(robot.get_lidar_scan(), "robot 'blind' has no sensor 'lidar'", HardwareError);
  CHECK_THROWS_WITH_AS(robot.get_map(), "robot 'blind' has no sensor 'lidar', which a map needs", HardwareError);
  CHECK_THROWS_WITH_AS(robot.explore(), "robot 'blind' has no sensor 'lidar', which exploring needs", HardwareError);
  CHECK(robot.wait(robot.move_to(1.0, 0.5)).success);
  CHECK(distance(toy.port().pose.position(), {1.0, 0.5}) < 0.25);
}

TEST_CASE("observers see every tick, and may come and go while they are told") {
  Toy toy;
  Robot robot(*toy.world);
  Runtime& runtime = robot.runtime();
  std::vector<Time> stamps;
  std::size_t samples = 0;
  int once = 0;
  int late = 0;
  std::uint64_t self = 0;
  const std::uint64_t id = runtime.observe([&](const TickView& view) {
    stamps.push_back(view.now);
    samples += view.samples.size();
    CHECK(&view.robot == &runtime);
    CHECK(view.pose.stamp == view.now);
  });
  self = runtime.observe([&](const TickView&) {
    ++once;
    runtime.unobserve(self);
    runtime.observe([&](const TickView&) { ++late; });
  });
  const Time start = toy.world->now();
  robot.sleep(1.0);
  CHECK(stamps.size() == 50);
  CHECK(stamps.front() == start + kControlPeriod);
  CHECK(samples == 50 + 50 + 10 + 10);
  CHECK(once == 1);
  CHECK(late == 49);
  runtime.unobserve(id);
  robot.sleep(1.0);
  CHECK(stamps.size() == 50);
}

TEST_CASE("what an observer throws comes out once the tick is complete") {
  Toy toy({"3we_standard_v2", "3we_standard_v2"});
  Robot first(*toy.world, 0);
  Robot second(*toy.world, 1);
  int seen = 0;
  first.runtime().observe([](const TickView&) { throw std::runtime_error("the disk is full"); });
  second.runtime().observe([&](const TickView&) { ++seen; });
  const Time start = toy.world->now();
  CHECK_THROWS_WITH_AS(toy.world->tick(), "the disk is full", std::runtime_error);
  CHECK(seen == 1);
  CHECK(toy.world->now() == start + kControlPeriod);
  CHECK(first.runtime().fault().empty());
}

TEST_CASE("an observer can cancel a motion but not let time go by") {
  Toy toy({"3we_standard_v2"}, restless());
  Robot robot(*toy.world);
  const MotionHandle motion = robot.move_to(2.0, 0.0);
  robot.runtime().observe([&](const TickView& view) {
    if (view.now > 1s) motion->cancel();
  });
  CHECK(robot.wait(motion).reason == Reason::cancelled);
  robot.runtime().observe([&](const TickView&) { robot.sleep(1.0); });
  CHECK_THROWS_AS(toy.world->tick(), ContractError);
}

TEST_CASE("nothing that moves time can be called in the middle of a tick") {
  Toy toy({"3we_standard_v2", "3we_standard_v2"}, restless());
  World& world = *toy.world;
  Robot robot(world, 0);
  Robot other(world, 1);
  const auto snapshot = std::shared_ptr<const World::Snapshot>();
  const std::vector<std::pair<const char*, std::function<void()>>> calls = {
      {"tick", [&] { world.tick(); }},
      {"run", [&] { world.run(1s); }},
      {"wait", [&] { world.wait(world.sleep(1s)); }},
      {"wait for a motion", [&] { (void)other.wait(other.move_forward(1.0)); }},
      {"thinking", [&] { robot.thinking(1.0, [] {}); }},
      {"execute_action", [&] { robot.execute_action({}); }},
      {"reset", [&] { world.reset({}); }},
      {"save", [&] { (void)world.save(); }},
      {"restore", [&] { world.restore(snapshot); }},
  };
  for (const auto& [name, call] : calls) {
    CAPTURE(name);
    std::string refusal;
    const std::uint64_t id = robot.runtime().observe([&, call = call](const TickView&) {
      try {
        call();
      } catch (const ContractError& error) {
        refusal = error.what();
      }
    });
    const WaitHandle pending = world.sleep(1h);
    const Time before = world.now();
    world.tick();
    CHECK(refusal == "an observer can neither wait nor reset nor save nor restore");
    CHECK(world.now() == before + kControlPeriod);
    CHECK_FALSE(world.held());

    // and then the world is as usable as before
    robot.runtime().unobserve(id);
    other.stop();
    world.forget(pending);
    robot.sleep(0.02);
    CHECK(world.now() == before + 2 * kControlPeriod);
  }
}

TEST_CASE("a zone that is none is refused") {
  Toy toy({"3we_standard_v2"});
  Robot robot(*toy.world);
  CHECK_THROWS_WITH_AS(robot.set_zones({{{{0.0, 0.0}, {1.0, 0.0}}}}), "a zone needs at least 3 corners, not 2",
                       ContractError);
  CHECK_THROWS_AS(robot.set_zones({{{{0.0, 0.0}, {1.0, 0.0}, {1.0, kNaN}}}}), ContractError);
  CHECK_THROWS_AS(robot.set_zones({{{{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}}, 0.0}}), ContractError);
}

TEST_CASE("progress is told every 0.1 s, and what it throws cancels the motion") {
  Toy toy({"3we_standard_v2"});
  Robot robot(*toy.world);
  std::vector<Progress> told;
  const MoveResult result =
      robot.wait(robot.move_forward(1.0), [&](const Progress& progress) { told.push_back(progress); });
  CHECK(result.success);
  CHECK(std::fabs(static_cast<double>(told.size()) - result.duration / 0.1) < 2.0);
  CHECK(told.front().distance_left > told.back().distance_left);
  CHECK(told.front().time_left > told.back().time_left);
  CHECK(told.back().distance_driven == doctest::Approx(result.distance).epsilon(0.05));

  const MotionHandle motion = robot.move_forward(-1.0);
  CHECK_THROWS_WITH_AS(robot.wait(motion, [](const Progress&) { throw std::runtime_error("enough"); }), "enough",
                       std::runtime_error);
  CHECK(motion->result().reason == Reason::cancelled);
  CHECK(robot.wait(robot.move_forward(-0.2)).success);
}

TEST_CASE("robots of one world drive at the same time") {
  Toy toy({"3we_standard_v2", "turtlebot_like"});
  Robot first(*toy.world, 0);
  Robot second(*toy.world, 1);
  const MotionHandle one = first.move_forward(1.0);
  const MotionHandle other = second.move_forward(1.0);
  const Time start = toy.world->now();
  CHECK(first.wait(one).success);
  CHECK(second.wait(other).success);
  CHECK(to_seconds(toy.world->now() - start) < 1.5 * std::max(one->result().duration, other->result().duration));
  CHECK_THROWS_AS(toy.world->robot(2), ContractError);
}
