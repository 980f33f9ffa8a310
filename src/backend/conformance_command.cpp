// What the port owes a command: to refuse it, to limit it, to let it expire.
#include <cmath>
#include <limits>

#include "backend/conformance_bench.hpp"

namespace threewe::backend::conformance {

namespace {

void commands_that_are_not_finite_are_refused(const Context& context) {
  Bench bench = context.connected();
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    for (const Velocity& velocity : {Velocity{bad, 0.0, 0.0}, Velocity{0.0, bad, 0.0}, Velocity{0.0, 0.0, bad}}) {
      expect_throws<ContractError>([&] { bench.port().command(velocity, bench.now() + 200ms); },
                                   "a velocity that is not finite", "ContractError");
    }
  }
}

void sideways_is_refused(const Context& context) {
  Bench bench = context.connected();
  applies_if(bench.features().kinematics == Kinematics::differential, "the base can drive sideways");
  expect_throws<ContractError>([&] { bench.port().command({0.0, 0.1, 0.0}, bench.now() + 200ms); },
                               "vy on a differential base", "ContractError");
}

void a_refused_command_changes_nothing(const Context& context) {
  Bench bench = context.connected();
  bench.drive({bench.cruise(), 0.0, 0.0}, 500ms);
  bench.port().command({}, bench.now() + 200ms);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  expect_throws<ContractError>([&] { bench.port().command({kNan, 0.0, 0.0}, bench.now() + 200ms); },
                               "a velocity that is not finite", "ContractError");
  bench.wait(1s);
  const Odometry odometry = bench.odometry();
  expect(is_finite(odometry.pose) && std::abs(odometry.velocity.vx) < 0.02,
         "after a stop and a refused command the robot drives at {:.3f} m/s", odometry.velocity.vx);
}

void an_expired_command_stops_the_robot(const Context& context) {
  Bench bench = context.connected();
  bench.drive({bench.cruise(), 0.0, 0.0}, 1s);
  const Vec2 start = bench.odometry().pose.position();
  bench.wait(2s);
  const Odometry end = bench.odometry();
  expect(std::abs(end.velocity.vx) < 0.02, "2 s after the last command the robot still drives at {:.3f} m/s",
         end.velocity.vx);
  const double coasted = distance(start, end.pose.position());
  expect(coasted < 0.7 * bench.cruise(), "the robot drove {:.3f} m on a command that was valid for 0.2 s at {:.2f} m/s",
         coasted, bench.cruise());
}

void a_command_lasts_while_it_is_valid(const Context& context) {
  Bench bench = context.connected();
  bench.drive({}, 200ms);
  bench.port().command({bench.cruise(), 0.0, 0.0}, bench.now() + 1s);
  bench.wait(2s);
  const double driven = bench.odometry().pose.x;
  expect(std::abs(driven - bench.cruise()) < 0.3 * bench.cruise(),
         "a command of {:.2f} m/s that was valid for 1 s moved the robot by {:.3f} m", bench.cruise(), driven);
}

void zero_stops_the_robot(const Context& context) {
  Bench bench = context.connected();
  bench.drive({bench.cruise(), 0.0, 0.0}, 1s);
  bench.drive({}, 1s);
  const Velocity& v = bench.odometry().velocity;
  expect(norm({v.vx, v.vy}) < 0.02 && std::abs(v.omega) < 0.05,
         "1 s after a stop the robot drives at ({:.3f}, {:.3f}) m/s, {:.3f} rad/s", v.vx, v.vy, v.omega);
}

void a_stopped_robot_stands_still(const Context& context) {
  Bench bench = context.connected();
  bench.drive_and_stop({bench.cruise(), 0.0, 0.0}, 1s);
  const Pose2D before = bench.odometry().pose;
  bench.drive({}, 3s);
  const Pose2D crept = inverse(before) * bench.odometry().pose;
  expect(norm(crept.position()) < 0.005 && std::abs(crept.theta) < 0.01,
         "standing for 3 s, the robot moved by {:.4f} m and {:.4f} rad", norm(crept.position()), crept.theta);
}

void a_robot_stands_still_until_commanded(const Context& context) {
  Bench bench = context.connected();
  bench.wait(2s);
  const Pose2D pose = bench.odometry().pose;
  expect(norm(pose.position()) < 0.005 && std::abs(pose.theta) < 0.01,
         "without a command, the robot moved by {:.4f} m and {:.4f} rad", norm(pose.position()), pose.theta);
}

/// The highest mean speeds over any 100 ms, by the poses of odometry.
struct Fastest {
  double linear = 0.0;
  double angular = 0.0;
};

Fastest fastest(Bench& bench) {
  Fastest found;
  const std::vector<Sample> odometry = bench.of(SensorType::odometry);
  for (std::size_t from = 0, to = 0; to < odometry.size(); ++to) {
    while (odometry[to].measured - odometry[from].measured > 100ms) ++from;
    const double seconds = to_seconds(odometry[to].measured - odometry[from].measured);
    if (seconds < 0.05) continue;
    const Pose2D& a = std::get<Odometry>(odometry[from].data).pose;
    const Pose2D& b = std::get<Odometry>(odometry[to].data).pose;
    found.linear = std::max(found.linear, distance(a.position(), b.position()) / seconds);
    found.angular = std::max(found.angular, std::abs(wrap_angle(b.theta - a.theta)) / seconds);
  }
  return found;
}

void hardware_limits_hold(const Context& context) {
  Bench bench = context.connected();
  const Limits& limits = bench.profile().hardware_limits;
  bench.drive_and_stop({0.0, 0.0, 10.0 * limits.angular}, 1s);
  bench.drive_and_stop({10.0 * limits.linear, 0.0, 0.0}, 500ms);
  const Fastest seen = fastest(bench);
  expect(seen.linear <= 1.1 * limits.linear + 0.05, "driven at {:.2f} m/s; the drive's limit is {:.2f}", seen.linear,
         limits.linear);
  expect(seen.angular <= 1.1 * limits.angular + 0.05, "turned at {:.2f} rad/s; the drive's limit is {:.2f}",
         seen.angular, limits.angular);
}

constexpr Check kCommandChecks[] = {
    {"commands_that_are_not_finite_are_refused", commands_that_are_not_finite_are_refused},
    {"sideways_is_refused", sideways_is_refused},
    {"a_refused_command_changes_nothing", a_refused_command_changes_nothing},
    {"an_expired_command_stops_the_robot", an_expired_command_stops_the_robot},
    {"a_command_lasts_while_it_is_valid", a_command_lasts_while_it_is_valid},
    {"zero_stops_the_robot", zero_stops_the_robot},
    {"a_stopped_robot_stands_still", a_stopped_robot_stands_still},
    {"a_robot_stands_still_until_commanded", a_robot_stands_still_until_commanded},
    {"hardware_limits_hold", hardware_limits_hold},
};

}  // namespace

std::span<const Check> command_checks() { return kCommandChecks; }

}  // namespace threewe::backend::conformance
