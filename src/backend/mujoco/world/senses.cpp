#include "backend/mujoco/world/senses.hpp"

#include <algorithm>
#include <cstdint>
#include <span>

#include "core/exact.hpp"
#include "models/imu.hpp"
#include "models/lidar.hpp"
#include "models/odometry.hpp"
#include "models/ultrasonic.hpp"
#include "sim/step.hpp"

namespace threewe::backend::mujoco {
namespace {

using exports::Quaternion;
using exports::Vec3;

// Between two placements that are near each other, as the body has them a moment apart.
Transform between(const Transform& a, const Transform& b, double t) {
  const auto mix = [t](double from, double to) { return from + t * (to - from); };
  Quaternion q{mix(a.rotation.w, b.rotation.w), mix(a.rotation.x, b.rotation.x), mix(a.rotation.y, b.rotation.y),
               mix(a.rotation.z, b.rotation.z)};
  const double length = exact::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  q = {q.w / length, q.x / length, q.y / length, q.z / length};
  return {a.position + t * (b.position - a.position), q};
}

// Where the body was at a share of the last step, and at its end where the share is 1.
Transform place_at(std::span<const Transform> track, double share) {
  const double parts = static_cast<double>(track.size() - 1) * share;
  const std::size_t part = std::min(static_cast<std::size_t>(parts), track.size() - 2);
  return between(track[part], track[part + 1], parts - static_cast<double>(part));
}

// The share of a turn that a step sweeps; or the whole turn at its end.
void sweep_lidar(const sim::RobotModel& robot, std::span<const Vec3> beams, std::span<const Transform> track,
                 const Physics& physics, sim::RobotState& state) {
  const LidarSpec& lidar = *robot.profile.lidar;
  const auto turn = static_cast<std::uint64_t>(robot.turn);
  const std::uint64_t points = beams.size();
  const std::uint64_t share = lidar.rolling ? points / turn : points;
  const std::uint64_t first = lidar.rolling ? (state.steps - 1) % turn * share : 0;
  const std::span<float> ranges = std::span(state.lidar_points).subspan(first, share);
  const Vec3 mount{lidar.base_from_lidar.x, lidar.base_from_lidar.y, lidar.height};
  for (std::size_t i = 0; i < share; ++i) {
    const double when = lidar.rolling ? static_cast<double>(i) / static_cast<double>(share) : 1.0;
    const Transform base = place_at(track, when);
    const double hit = physics.cast(base * mount, rotated(base.rotation, beams[first + i])).distance;
    ranges[i] = static_cast<float>(hit < 0.0 ? lidar.range_max : std::min(hit, lidar.range_max));
  }

  const std::uint64_t turns = (state.steps - 1) / turn;
  models::measure_ranges(lidar, state.key(Stream::lidar), state.lidar_bias, turns * points + first, ranges,
                         state.variation);
}

// The nearest surface in the cone, along the height of the sensor, that sends the sound back; what it glances off still
// hides what stands behind.
double nearest_sonar_return(const UltrasonicSpec& spec, const Pose2D& mount, const Transform& base,
                            const Physics& physics) {
  constexpr double kBetweenRays = 0.25 * exact::kPi / 180.0;  // [rad]; a leg of 2 cm at 2 m is twice as wide
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

void ping(const sim::RobotModel& robot, std::size_t sensor, const Transform& base, const Physics& physics,
          sim::RobotState& state) {
  const UltrasonicSpec& spec = *robot.profile.ultrasonics;
  const double echo = nearest_sonar_return(spec, spec.mounts[sensor].base_from_ultrasonic, base, physics);
  RngKey key = state.key(Stream::ultrasonic);
  key.sensor = static_cast<std::uint16_t>(sensor);
  const std::uint64_t pings = state.steps / static_cast<std::uint64_t>(robot.ultrasonic_interval);
  state.ultrasonic_range = models::measure_range(spec, key, (pings - 1) / spec.mounts.size(), echo);
}

}  // namespace

std::vector<Vec3> beams_of(const LidarSpec& lidar) {
  const models::ScanPattern pattern = models::scan_pattern(lidar);
  std::vector<Vec3> beams;
  for (int i = 0; i < lidar.points_per_turn; ++i) {
    const auto [sin, cos] = exact::sincos(lidar.base_from_lidar.theta + pattern.first_angle + i * pattern.angle_step);
    beams.push_back({cos, sin, 0.0});
  }
  return beams;
}

void sense(const sim::RobotModel& robot, const std::vector<Vec3>& beams, std::size_t index, const Passage& passage,
           Physics& physics, sim::RobotState& state) {
  const RobotProfile& profile = robot.profile;
  const std::vector<Transform>& track = physics.track(index);
  physics.look_for(index);
  if (sim::imu_ready(robot, state)) {
    state.imu = models::measure_imu(*profile.imu, state.key(Stream::imu), passage.yaw_rate, passage.acceleration,
                                    state.imu_state, state.variation);
  }
  if (const auto sensor = sim::ping_ready(robot, state)) ping(robot, *sensor, track.back(), physics, state);
  if (profile.lidar && (profile.lidar->rolling || sim::scan_ready(robot, state))) {
    sweep_lidar(robot, beams, track, physics, state);
  }
  if (sim::odometry_ready(robot, state)) {
    models::measure_odometry(robot.odometer, state.wheel_errors, state.wheel_angles, state.odometry);
  }
}

}  // namespace threewe::backend::mujoco
