// What a simulated world says about itself, against what its robot measures.
#include <cmath>

#include "backend/conformance_bench.hpp"
#include "threewe/scene/truth_view.hpp"

namespace threewe::backend::conformance {

namespace {

Bench with_truth(const Context& context) {
  Bench bench = context.connected();
  applies_if(bench.truth() != nullptr, "the world is not simulated: it has no truth");
  return bench;
}

const scene::TruthView& truth(Bench& bench) { return *bench.truth(); }

void truth_begins_at_the_start_pose(const Context& context) {
  Bench bench = with_truth(context);
  const Pose2D off = inverse(truth(bench).start_pose()) * truth(bench).true_pose();
  expect(norm(off.position()) < 1e-6 && std::abs(off.theta) < 1e-6,
         "a fresh robot is {:.3f} m and {:.3f} rad from its start pose", norm(off.position()), off.theta);
}

void truth_agrees_with_odometry(const Context& context) {
  Bench bench = with_truth(context);
  bench.drive_and_stop({0.0, 0.0, bench.turning()}, from_seconds(0.6 / bench.turning()));
  bench.drive_and_stop({bench.cruise(), 0.0, 0.0}, from_seconds(0.8 / bench.cruise()));
  const Pose2D odom = bench.odometry().pose;
  const Pose2D driven = inverse(truth(bench).start_pose()) * truth(bench).true_pose();
  expect(distance(odom.position(), driven.position()) < 0.2 && std::abs(wrap_angle(odom.theta - driven.theta)) < 0.25,
         "the robot stands at ({:.3f}, {:.3f}, {:.3f}) from its start, by odometry at ({:.3f}, {:.3f}, {:.3f})",
         driven.x, driven.y, driven.theta, odom.x, odom.y, odom.theta);
}

void true_velocity_is_in_the_body_frame(const Context& context) {
  Bench bench = with_truth(context);
  bench.drive_and_stop({0.0, 0.0, bench.turning()}, from_seconds(1.2 / bench.turning()));
  bench.drive({bench.cruise(), 0.0, 0.0}, 1s);
  const Velocity v = truth(bench).true_velocity();
  expect(std::abs(v.vx - bench.cruise()) < 0.2 * bench.cruise() && std::abs(v.vy) < 0.2 * bench.cruise(),
         "driving forward at {:.2f} m/s is in truth ({:.3f}, {:.3f}) m/s", bench.cruise(), v.vx, v.vy);
}

void distance_driven_is_counted(const Context& context) {
  Bench bench = with_truth(context);
  bench.drive_and_stop({bench.cruise(), 0.0, 0.0}, from_seconds(0.8 / bench.cruise()));
  bench.drive_and_stop({-bench.cruise(), 0.0, 0.0}, from_seconds(0.8 / bench.cruise()));
  const double driven = truth(bench).distance_driven();
  expect(std::abs(driven - 1.6) < 0.2, "0.8 m forward and back count as {:.3f} m", driven);
}

void a_free_drive_has_no_collision(const Context& context) {
  Bench bench = with_truth(context);
  bench.drive_and_stop({bench.cruise(), 0.0, 0.0}, 1s);
  const double speed = truth(bench).max_collision_speed();
  expect(speed == 0.0, "a drive over free floor counts as a collision at {:.3f} m/s", speed);
}

void free_poses_follow_from_the_seed(const Context& context) {
  Bench bench = with_truth(context);
  const Pose2D first = truth(bench).sample_free_pose(1);
  const Pose2D second = truth(bench).sample_free_pose(2);
  bench.drive({0.0, 0.0, bench.turning()}, 1s);
  expect(truth(bench).sample_free_pose(1) == first, "seed 1 gave two different free poses");
  expect(!(first == second), "seeds 1 and 2 gave the same free pose");
}

void no_path_is_shorter_than_the_straight_line(const Context& context) {
  Bench bench = with_truth(context);
  const Vec2 start = truth(bench).start_pose().position();
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const Vec2 goal = truth(bench).sample_free_pose(seed).position();
    const double length = truth(bench).geodesic(start, goal);
    expect(length >= distance(start, goal) - 0.1, "a path of {:.3f} m between points {:.3f} m apart", length,
           distance(start, goal));
  }
}

constexpr Check kTruthChecks[] = {
    {"truth_begins_at_the_start_pose", truth_begins_at_the_start_pose},
    {"truth_agrees_with_odometry", truth_agrees_with_odometry},
    {"true_velocity_is_in_the_body_frame", true_velocity_is_in_the_body_frame},
    {"distance_driven_is_counted", distance_driven_is_counted},
    {"a_free_drive_has_no_collision", a_free_drive_has_no_collision},
    {"free_poses_follow_from_the_seed", free_poses_follow_from_the_seed},
    {"no_path_is_shorter_than_the_straight_line", no_path_is_shorter_than_the_straight_line},
};

}  // namespace

std::span<const Check> truth_checks() { return kTruthChecks; }

}  // namespace threewe::backend::conformance
