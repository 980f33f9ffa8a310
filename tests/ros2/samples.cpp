// Samples of a simulated robot that drives at given velocities: what a record of a served one must be equal to.
//
//   ros2_samples SCENE PROFILE SEED
//
// Each line "VX VY OMEGA COUNT" of its input drives COUNT control periods. It prints a sample a line, as JSON: the
// sensor, when it was measured [ns], and its values; of a picture, whose pixels are many, the sum.
#include <cstdio>
#include <iostream>
#include <numeric>
#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "threewe/backend/registry.hpp"
#include "threewe/core/time.hpp"

using namespace threewe;

namespace {

struct Values {
  std::string operator()(const LaserScan& scan) const {
    return fmt::format("{}, {}, {}, {}, {}, {}", scan.angle_min, scan.angle_increment, scan.time_increment,
                       scan.range_min, scan.range_max, fmt::join(scan.ranges, ", "));
  }
  std::string operator()(const IMUData& imu) const {
    return fmt::format("{}, {}", fmt::join(imu.angular_velocity, ", "), fmt::join(imu.linear_acceleration, ", "));
  }
  std::string operator()(const Odometry& odometry) const {
    const auto& [pose, velocity] = odometry;
    return fmt::format("{}, {}, {}, {}, {}, {}", pose.x, pose.y, pose.theta, velocity.vx, velocity.vy, velocity.omega);
  }
  std::string operator()(const BatteryState& battery) const {
    return fmt::format("{}, {}, {}", battery.voltage, battery.current, battery.charge);
  }
  std::string operator()(const RangeData& range) const {
    return fmt::format("{}, {}, {}, {}", range.field_of_view, range.range_min, range.range_max, range.range);
  }
  std::string operator()(const Picture& picture) const {
    const auto& color = picture.image().color;
    return fmt::format("{}", std::accumulate(color.begin(), color.end(), std::uint64_t{0}));
  }
};

}  // namespace

int main(int count, char** arguments) {
  if (count != 4) {
    std::fputs("usage: ros2_samples SCENE PROFILE SEED\n", stderr);
    return 2;
  }
  backend::WorldOptions options;
  options.scene = arguments[1];
  options.robots = {arguments[2]};
  options.seed = std::stoull(arguments[3]);
  const auto world = backend::make_world("mock", options);
  backend::RobotPort& port = world->robot(0);
  port.connect();
  Velocity velocity;
  int periods = 0;
  while (std::cin >> velocity.vx >> velocity.vy >> velocity.omega >> periods) {
    for (; periods > 0; --periods) {
      port.command(velocity, world->now() + kControlPeriod);
      world->advance_to(world->now() + kControlPeriod);
      for (const Sample& sample : port.poll()) {
        fmt::print(R"({{"sensor": "{}", "measured": {}, "values": [{}]}})"
                   "\n",
                   port.features().sensors[sample.sensor].name, sample.measured.count(),
                   std::visit(Values(), sample.data));
      }
    }
  }
  return 0;
}
