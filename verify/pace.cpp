// How many times faster than real time one core simulates a robot, and runs its mind: verify_pace SEED.
//
// The robot wanders through the office by set_velocity, noise on, and turns away from what its lidar sees ahead; how
// far it came is printed too. Then it drives from goal to goal with its whole mind. Times are CPU seconds of this one
// thread; of the whole mind wall seconds, too.
#include <cmath>
#include <cstdio>
#include <ctime>
#include <memory>
#include <variant>

#include "number.hpp"
#include "threewe/backend/registry.hpp"
#include "threewe/robot/robot.hpp"
#include "threewe/scene/truth_view.hpp"

using namespace threewe;

namespace {

constexpr Duration kDrive = 120s;

double wall_seconds() {
  std::timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double cpu_seconds() {
  std::timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

// Ahead in gentle arcs; on the spot, to the left, while something is near ahead.
Velocity wander(const LaserScan& scan, Time now) {
  const double side = now / 7s % 2 == 0 ? 0.25 : -0.25;
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const double angle = wrap_angle(scan.angle_min + static_cast<double>(i) * scan.angle_increment);
    const bool near = scan.ranges[i] > 0.0F && scan.ranges[i] < 0.6F;
    if (near && std::fabs(angle) < 0.7) return {0.0, 0.0, 0.8};
  }
  return {0.4, 0.0, side};
}

struct Pace {
  double times_real_time;
  double metres;
  long pixels = 0;  // that were drawn
};

// With `watching`, every picture of the camera is looked at.
Pace with_mind(std::uint64_t seed, bool watching) {
  Robot robot({.seed = seed});
  long pixels = 0;
  if (watching) {
    robot.runtime().observe([&pixels](const TickView& tick) {
      for (const Sample& sample : tick.samples) {
        if (const auto* picture = std::get_if<Picture>(&sample.data)) {
          pixels += static_cast<long>(picture->image().color.size() / 3);
        }
      }
    });
  }
  const double begin = cpu_seconds();
  const Time end = robot.world().now() + kDrive;
  while (robot.world().now() < end) {
    const Velocity v = wander(robot.get_lidar_scan(), robot.world().now());
    robot.set_velocity(v.vx, v.vy, v.omega);
    robot.sleep(0.1);
  }
  const double seconds = cpu_seconds() - begin;
  return {to_seconds(kDrive) / seconds, robot.simulation()->distance_driven(), pixels};
}

// From goal to goal, through rooms that it has never seen: everything that a mind does.
struct WholePace {
  double times_wall_time;
  double times_cpu_time;
  double metres;
};

WholePace with_whole_mind(std::uint64_t seed) {
  Robot robot({.seed = seed});
  const double wall = wall_seconds();
  const double cpu = cpu_seconds();
  const Time end = robot.world().now() + kDrive;
  for (std::uint64_t goal = 0; robot.world().now() < end;) {
    if (!robot.runtime().motion()) {
      const Pose2D place = robot.simulation()->sample_free_pose(1000 * seed + goal++);
      (void)robot.move_to(place.x, place.y);
    }
    robot.sleep(0.1);
  }
  const double robot_seconds = to_seconds(kDrive);
  return {robot_seconds / (wall_seconds() - wall), robot_seconds / (cpu_seconds() - cpu),
          robot.simulation()->distance_driven()};
}

Pace simulation_alone(std::uint64_t seed) {
  backend::WorldOptions options;
  options.seed = seed;
  const auto world = backend::make_world("mock", options);
  backend::RobotPort& port = world->robot(0);
  port.connect();
  Velocity velocity;
  const double begin = cpu_seconds();
  for (Time t{}; t < kDrive; t += kControlPeriod) {
    port.command(velocity, t + 200ms);
    world->advance_to(t + kControlPeriod);
    for (const Sample& sample : port.poll()) {
      if (const auto* scan = std::get_if<LaserScan>(&sample.data)) velocity = wander(*scan, t);
    }
  }
  return {to_seconds(kDrive) / (cpu_seconds() - begin), port.truth()->distance_driven()};
}

}  // namespace

int main(int argc, char** argv) {
  const auto seed = parse_number(argc == 2 ? argv[1] : "");
  if (!seed) {
    std::fputs("usage: verify_pace SEED\n", stderr);
    return 2;
  }
  const Pace simulation = simulation_alone(*seed);
  const Pace mind = with_mind(*seed, false);
  const Pace camera = with_mind(*seed, true);
  const WholePace whole = with_whole_mind(*seed);
  std::printf("simulation %.1f\nsimulation_metres %.1f\n", simulation.times_real_time, simulation.metres);
  std::printf("mind %.1f\nmind_metres %.1f\n", mind.times_real_time, mind.metres);
  std::printf("whole_mind %.1f\nwhole_mind_cpu %.1f\nwhole_mind_metres %.1f\n", whole.times_wall_time,
              whole.times_cpu_time, whole.metres);
  std::printf("camera %.1f\ncamera_pixels_per_second %.0f\n", camera.times_real_time,
              static_cast<double>(camera.pixels) / to_seconds(kDrive));
}
