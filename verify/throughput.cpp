// How many times faster than real time one core simulates a robot, and runs its autonomy stack: verify_throughput SEED.
//
// The robot drives at random through the office by set_velocity, noise on, and turns away from what its lidar sees
// ahead; how far it came is printed too. Times are CPU seconds of this one thread.
#include <cmath>
#include <cstdio>
#include <memory>
#include <variant>

#include "number.hpp"
#include "seconds.hpp"
#include "threewe/backend/registry.hpp"
#include "threewe/robot/robot.hpp"
#include "threewe/scene/truth_view.hpp"

using namespace threewe;

namespace {

constexpr Duration kDrive = 120s;

double cpu_seconds() { return seconds_by(CLOCK_PROCESS_CPUTIME_ID); }

// Ahead in gentle arcs; on the spot, to the left, while something is near ahead.
Velocity random_walk(const LaserScan& scan, Time now) {
  const double side = now / 7s % 2 == 0 ? 0.25 : -0.25;
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const double angle = wrap_angle(scan.angle_min + static_cast<double>(i) * scan.angle_increment);
    const bool near = scan.ranges[i] > 0.0F && scan.ranges[i] < 0.6F;
    if (near && std::fabs(angle) < 0.7) return {0.0, 0.0, 0.8};
  }
  return {0.4, 0.0, side};
}

struct Throughput {
  double times_real_time;
  double metres;
  long pixels = 0;  // that were drawn
};

// With `watching`, every picture of the camera is looked at.
Throughput with_autonomy(std::uint64_t seed, bool watching) {
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
    const Velocity v = random_walk(robot.get_lidar_scan(), robot.world().now());
    robot.set_velocity(v.vx, v.vy, v.omega);
    robot.sleep(0.1);
  }
  const double seconds = cpu_seconds() - begin;
  return {to_seconds(kDrive) / seconds, robot.simulation()->distance_driven(), pixels};
}

Throughput simulation_alone(std::uint64_t seed) {
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
      if (const auto* scan = std::get_if<LaserScan>(&sample.data)) velocity = random_walk(*scan, t);
    }
  }
  return {to_seconds(kDrive) / (cpu_seconds() - begin), world->truth_service()->truth(0).distance_driven()};
}

}  // namespace

int main(int argc, char** argv) {
  const auto seed = parse_number(argc == 2 ? argv[1] : "");
  if (!seed) {
    std::fputs("usage: verify_throughput SEED\n", stderr);
    return 2;
  }
  const Throughput simulation = simulation_alone(*seed);
  const Throughput autonomy = with_autonomy(*seed, false);
  const Throughput camera = with_autonomy(*seed, true);
  std::printf("simulation %.1f\nsimulation_metres %.1f\n", simulation.times_real_time, simulation.metres);
  std::printf("autonomy %.1f\nautonomy_metres %.1f\n", autonomy.times_real_time, autonomy.metres);
  std::printf("camera %.1f\ncamera_pixels_per_second %.0f\n", camera.times_real_time,
              static_cast<double>(camera.pixels) / to_seconds(kDrive));
}
