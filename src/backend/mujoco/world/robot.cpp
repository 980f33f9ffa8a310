#include "backend/mujoco/world/robot.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "threewe/core/errors.hpp"
#include "threewe/hardware/limits.hpp"
#include "threewe/models/battery.hpp"
#include "threewe/models/imu.hpp"
#include "threewe/models/lidar.hpp"
#include "threewe/models/ultrasonic.hpp"

namespace threewe::backend::mujoco {
namespace {

using exports::Quaternion;
using exports::Vec3;

void require(const RobotProfile& profile, bool ok, const std::string& what) {
  if (!ok) throw ConfigError(fmt::format("{}: {}", profile.name, what));
}

std::uint64_t whole_steps(const RobotProfile& profile, const char* field, Duration duration) {
  require(profile, duration.count() % kStep.count() == 0,
          fmt::format("{} of {} s is not a whole number of {} s steps, which this simulator takes", field,
                      to_seconds(duration), to_seconds(kStep)));
  return static_cast<std::uint64_t>(duration / kStep);
}

std::vector<Vec3> beams_of(const LidarSpec& lidar) {
  const models::ScanPattern pattern = models::scan_pattern(lidar);
  std::vector<Vec3> beams;
  for (int i = 0; i < lidar.points_per_turn; ++i) {
    const auto [sin, cos] = exact::sincos(lidar.base_from_lidar.theta + pattern.first_angle + i * pattern.angle_step);
    beams.push_back({cos, sin, 0.0});
  }
  return beams;
}

// Between two placements that are near each other, as the body has them a moment apart.
Transform between(const Transform& a, const Transform& b, double t) {
  const auto mix = [t](double from, double to) { return from + t * (to - from); };
  Quaternion q{mix(a.rotation.w, b.rotation.w), mix(a.rotation.x, b.rotation.x), mix(a.rotation.y, b.rotation.y),
               mix(a.rotation.z, b.rotation.z)};
  const double length = exact::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  q = {q.w / length, q.x / length, q.y / length, q.z / length};
  return {a.position + t * (b.position - a.position), q};
}

// What the motors are to do: the firmware takes a command that arrives within the hardware limits.
WheelSpeeds obey(const RobotModel& robot, const Velocity& sent, RobotState& state) {
  state.commands[(state.steps + robot.command_latency) % kMaxLatencySteps] = sent;
  const Velocity& command = state.commands[state.steps % kMaxLatencySteps];
  return wheel_speeds(robot.profile.body.wheels, within_limits(robot.profile.hardware_limits, command));
}

double supply_of(const RobotModel& robot, const RobotState& state) {
  return robot.profile.battery ? models::supply_ratio(*robot.profile.battery, state.battery) : 1.0;
}

void pay(const RobotModel& robot, const Pose2D& pose_before, const Velocity& before, const Physics& physics,
         RobotState& state) {
  if (!robot.profile.battery) return;
  // momentum keeps its direction while the body turns beneath it
  const auto [sin, cos] = exact::sincos(pose_before.theta - physics.pose().theta);
  const Velocity carried{cos * before.vx - sin * before.vy, sin * before.vx + cos * before.vy, before.omega};
  const Velocity rolling = body_velocity(robot.profile.body.wheels, physics.wheel_speeds());
  const double power = models::drive_power(robot.drive, robot.traction, carried, physics.velocity(), rolling);
  models::drain_battery(*robot.profile.battery, power, to_seconds(kStep), state.battery);
}

// Where the body was at a share of the last step, and at its end where the share is 1.
Transform place_at(std::span<const Transform> track, double share) {
  const double parts = static_cast<double>(track.size() - 1) * share;
  const std::size_t part = std::min(static_cast<std::size_t>(parts), track.size() - 2);
  return between(track[part], track[part + 1], parts - static_cast<double>(part));
}

// The share of a turn that a step sweeps; or the whole turn at its end.
void sweep_lidar(const RobotModel& robot, const Physics& physics, RobotState& state) {
  const LidarSpec& lidar = *robot.profile.lidar;
  const std::uint64_t points = robot.beams.size();
  const std::uint64_t share = lidar.rolling ? points / robot.turn : points;
  const std::uint64_t first = lidar.rolling ? (state.steps - 1) % robot.turn * share : 0;
  const std::span<float> ranges = std::span(state.lidar_points).subspan(first, share);
  const Vec3 mount{lidar.base_from_lidar.x, lidar.base_from_lidar.y, lidar.height};
  for (std::size_t i = 0; i < share; ++i) {
    const double when = lidar.rolling ? static_cast<double>(i) / static_cast<double>(share) : 1.0;
    const Transform base = place_at(physics.track(), when);
    const double hit = physics.cast(base * mount, rotated(base.rotation, robot.beams[first + i])).distance;
    ranges[i] = static_cast<float>(hit < 0.0 ? lidar.range_max : std::min(hit, lidar.range_max));
  }

  const std::uint64_t turns = (state.steps - 1) / robot.turn;
  models::measure_ranges(lidar, state.key(Stream::lidar), state.lidar_bias, turns * points + first, ranges);
}

// The nearest surface in the cone, along the height of the sensor, that sends the sound back; what it glances off still
// hides what stands behind.
double nearest_echo(const UltrasonicSpec& spec, const Pose2D& mount, const Physics& physics) {
  constexpr double kBetweenRays = 0.25 * exact::kPi / 180.0;  // [rad]; a leg of 2 cm at 2 m is twice as wide
  const Transform& base = physics.track().back();
  const int rays = 1 + static_cast<int>(spec.field_of_view / kBetweenRays);
  const Vec3 from = base * Vec3{mount.x, mount.y, spec.height};
  const double steepest = exact::cos(spec.max_incidence);
  double nearest = spec.range_max;
  for (int i = 0; i < rays; ++i) {
    const double bearing = spec.field_of_view * (static_cast<double>(i) / (rays - 1) - 0.5);
    const auto [sin, cos] = exact::sincos(mount.theta + bearing);
    const Vec3 direction = rotated(base.rotation, {cos, sin, 0.0});
    const auto [distance, normal] = physics.cast(from, direction);
    const double facing = -(direction.x * normal.x + direction.y * normal.y + direction.z * normal.z);
    if (distance >= 0.0 && facing >= steepest) nearest = std::min(nearest, distance);
  }
  return nearest;
}

void ping(const RobotModel& robot, std::size_t sensor, const Physics& physics, RobotState& state) {
  const UltrasonicSpec& spec = *robot.profile.ultrasonics;
  const double echo = nearest_echo(spec, spec.mounts[sensor].base_from_ultrasonic, physics);
  const std::uint64_t pings = state.steps / robot.ultrasonic_interval;
  state.ultrasonic_range = models::measure_range(
      spec, state.key(Stream::ultrasonic, static_cast<std::uint16_t>(sensor)), (pings - 1) / spec.mounts.size(), echo);
}

void sense(const RobotModel& robot, const Passage& passage, const Physics& physics, RobotState& state) {
  const RobotProfile& profile = robot.profile;
  if (imu_ready(robot, state)) {
    state.imu = models::measure_imu(*profile.imu, state.key(Stream::imu), passage.yaw_rate, passage.acceleration,
                                    state.imu_state);
  }
  if (const auto sensor = ping_ready(robot, state)) ping(robot, *sensor, physics, state);
  if (profile.lidar && (profile.lidar->rolling || scan_ready(robot, state))) sweep_lidar(robot, physics, state);
  if (odometry_ready(robot, state)) {
    models::measure_odometry(robot.odometer, state.wheel_errors, physics.wheel_angles(), state.odometry);
  }
}

bool is_due(std::uint64_t period, const RobotState& state) {
  return period > 0 && state.steps > 0 && state.steps % period == 0;
}

}  // namespace

RobotModel make_robot(const RobotProfile& profile) {
  RobotModel robot{};
  robot.profile = profile;
  robot.drive = models::make_drive(profile, kStep);
  robot.traction = models::make_traction(profile, kStep);
  robot.odometer = models::make_odometer(profile.odometry, profile.body.wheels);

  robot.command_latency = whole_steps(profile, "command_latency", profile.command_latency);
  require(profile, robot.command_latency < kMaxLatencySteps,
          fmt::format("command_latency: at most {} s can be simulated", (kMaxLatencySteps - 1) * to_seconds(kStep)));
  robot.odometry_period = whole_steps(profile, "odometry.period", profile.odometry.period);
  if (profile.imu) robot.imu_period = whole_steps(profile, "imu.period", profile.imu->period);
  if (profile.battery) robot.battery_period = whole_steps(profile, "battery.period", profile.battery->period);
  if (profile.ultrasonics) {
    robot.ultrasonic_interval = whole_steps(profile, "ultrasonics.interval", profile.ultrasonics->interval);
  }
  if (profile.lidar) {
    const LidarSpec& lidar = *profile.lidar;
    robot.turn = whole_steps(profile, "lidar.turn", lidar.turn);
    require(profile, lidar.points_per_turn <= kMaxLidarPoints,
            fmt::format("lidar.points_per_turn: at most {} can be simulated", kMaxLidarPoints));
    require(profile, !lidar.rolling || static_cast<std::uint64_t>(lidar.points_per_turn) % robot.turn == 0,
            fmt::format("lidar.points_per_turn: {} points cannot be spread evenly over the {} steps of a turn",
                        lidar.points_per_turn, robot.turn));
    robot.beams = beams_of(lidar);
  }
  return robot;
}

RobotState begin(const RobotModel& robot, const Pose2D& pose, std::uint64_t seed, std::uint32_t episode) {
  const RobotProfile& profile = robot.profile;
  RobotState state;
  state.seed = seed;
  state.episode = episode;
  state.start = pose;
  state.wheel_errors = models::draw_wheel_errors(profile.odometry, state.key(Stream::odometry));
  if (profile.battery) state.battery = models::start_battery(*profile.battery);
  if (profile.imu) state.imu_state = models::start_imu(*profile.imu, state.key(Stream::imu));
  if (profile.lidar) state.lidar_bias = models::lidar_bias(*profile.lidar, state.key(Stream::lidar));
  return state;
}

void step(const RobotModel& robot, const Velocity& sent, Physics& physics, RobotState& state) {
  const Pose2D pose = physics.pose();
  const Velocity velocity = physics.velocity();
  const Passage passage = physics.step(obey(robot, sent, state), supply_of(robot, state));
  pay(robot, pose, velocity, physics, state);
  state.max_collision_speed = std::max(state.max_collision_speed, passage.approach_speed);
  state.distance_driven += passage.distance_driven;
  ++state.steps;
  sense(robot, passage, physics, state);
}

bool imu_ready(const RobotModel& robot, const RobotState& state) { return is_due(robot.imu_period, state); }
bool odometry_ready(const RobotModel& robot, const RobotState& state) { return is_due(robot.odometry_period, state); }
bool scan_ready(const RobotModel& robot, const RobotState& state) { return is_due(robot.turn, state); }

bool battery_ready(const RobotModel& robot, const RobotState& state) {
  return robot.battery_period > 0 && state.steps > 0 && (state.steps - 1) % robot.battery_period == 0;
}

std::optional<std::size_t> ping_ready(const RobotModel& robot, const RobotState& state) {
  if (!is_due(robot.ultrasonic_interval, state)) return std::nullopt;
  return (state.steps / robot.ultrasonic_interval - 1) % robot.profile.ultrasonics->mounts.size();
}

std::span<const float> scan_points(const RobotModel& robot, const RobotState& state) {
  return std::span(state.lidar_points).first(robot.beams.size());
}

}  // namespace threewe::backend::mujoco
