// How many times faster than real time one core simulates a robot, and runs its mind: verify_pace SEED.
//
// The robot drives arcs by set_velocity through the office, noise on. Times are CPU seconds of this one thread.
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <memory>

#include "threewe/backend/registry.hpp"
#include "threewe/robot/robot.hpp"

using namespace threewe;

namespace {

constexpr double kRobotSeconds = 120.0;

double cpu_seconds() {
  std::timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

// What it drives in the second `i`: ahead, in arcs to both sides, seldom sideways.
Velocity velocity_at(int i) { return {0.35, i % 5 == 4 ? 0.1 : 0.0, i % 3 == 0 ? 0.5 : -0.2}; }

double with_mind(std::uint64_t seed) {
  Robot robot({.seed = seed});
  const double begin = cpu_seconds();
  for (int i = 0; i < static_cast<int>(kRobotSeconds); ++i) {
    const Velocity v = velocity_at(i);
    robot.set_velocity(v.vx, v.vy, v.omega, 1.0);
    robot.sleep(1.0);
  }
  return kRobotSeconds / (cpu_seconds() - begin);
}

double simulation_alone(std::uint64_t seed) {
  backend::WorldOptions options;
  options.seed = seed;
  const auto world = backend::make_world("mock", options);
  backend::RobotPort& port = world->robot(0);
  port.connect();
  const double begin = cpu_seconds();
  for (Time t{}; t < from_seconds(kRobotSeconds); t += kControlPeriod) {
    port.command(velocity_at(static_cast<int>(to_seconds(t))), t + 200ms);
    world->advance_to(t + kControlPeriod);
    (void)port.poll();
  }
  return kRobotSeconds / (cpu_seconds() - begin);
}

}  // namespace

int main(int argc, char** argv) {
  const std::uint64_t seed = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 0;
  std::printf("simulation %.1f\nmind %.1f\n", simulation_alone(seed), with_mind(seed));
}
