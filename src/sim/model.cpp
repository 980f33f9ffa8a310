#include "threewe/sim/model.hpp"

#include <cstddef>

#include <fmt/format.h>

#include "threewe/core/errors.hpp"

namespace threewe::sim {
namespace {

int whole_steps(const RobotProfile& profile, const char* field, Duration duration) {
  if (duration.count() % kStep.count() != 0) {
    throw ConfigError(fmt::format("{}: {} of {} s is not a whole number of {} s steps, which this simulator takes",
                                  profile.name, field, to_seconds(duration), to_seconds(kStep)));
  }
  return static_cast<int>(duration / kStep);
}

void require(const RobotProfile& profile, bool ok, const std::string& what) {
  if (!ok) throw ConfigError(fmt::format("{}: {}", profile.name, what));
}

RobotModel make_robot(const scene::Scene& scene, const RobotProfile& profile) {
  RobotModel robot;
  robot.profile = profile;
  robot.drive = models::make_drive(profile, kStep);
  robot.body = {profile.body.footprint, profile.body.mass, profile.body.inertia};
  require(profile, robot.body.footprint.corners().size() <= 16, "footprint: at most 16 corners can be simulated");

  constexpr double kFloorClearance = 0.01;  // [m], what lies lower is driven over
  const double fastest = robot.drive.no_load_speed * robot.drive.wheels.radius;
  const double reach =
      contact_reach(robot.body.footprint, fastest, profile.hardware_limits.angular, to_seconds(kStep));
  robot.solids = scene.solids_between(kFloorClearance, profile.body.height);
  robot.obstacles = std::make_shared<ShapeIndex>(scene::outlines(robot.solids), reach);

  robot.command_latency = whole_steps(profile, "command_latency", profile.command_latency);
  require(profile, robot.command_latency < kMaxLatencySteps,
          fmt::format("command_latency: at most {} s can be simulated", (kMaxLatencySteps - 1) * to_seconds(kStep)));
  robot.odometry_period = whole_steps(profile, "odometry.period", profile.odometry.period);
  if (profile.imu) robot.imu_period = whole_steps(profile, "imu.period", profile.imu->period);
  if (profile.battery) robot.battery_period = whole_steps(profile, "battery.period", profile.battery->period);

  if (profile.lidar) {
    const LidarSpec& lidar = *profile.lidar;
    robot.turn = whole_steps(profile, "lidar.turn", lidar.turn);
    require(profile, lidar.points_per_turn <= kMaxLidarPoints,
            fmt::format("lidar.points_per_turn: at most {} can be simulated", kMaxLidarPoints));
    require(profile, !lidar.rolling || lidar.points_per_turn % robot.turn == 0,
            fmt::format("lidar.points_per_turn: {} points cannot be spread evenly over the {} steps of a turn",
                        lidar.points_per_turn, robot.turn));
    robot.pattern = models::scan_pattern(lidar);
    robot.caster = std::make_shared<RayCaster>(scene.at_height(lidar.height), lidar.range_max);
  }
  return robot;
}

}  // namespace

std::shared_ptr<const Model> make_model(std::shared_ptr<const scene::Scene> scene,
                                        const std::vector<RobotProfile>& robots) {
  auto model = std::make_shared<Model>();
  model->scene = std::move(scene);
  for (const RobotProfile& profile : robots) {
    RobotModel robot = make_robot(*model->scene, profile);
    model->robots.push_back(std::move(robot));
  }
  return model;
}

}  // namespace threewe::sim
