// A robot on MuJoCo's physics: the motors' commands, the battery, and what sensors read. All but physics and rays is
// what `models` says, as in every simulator.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "backend/mujoco/world/physics.hpp"
#include "backend/mujoco/world/robot_state.hpp"
#include "threewe/hardware/profile.hpp"
#include "threewe/models/drive.hpp"
#include "threewe/models/odometry.hpp"

namespace threewe::backend::mujoco {

/// What never changes. Periods and latencies are counted in steps.
struct RobotModel {
  RobotProfile profile;
  models::Drive drive;
  models::Traction traction;
  models::Odometer odometer;
  std::uint64_t command_latency = 0;
  std::uint64_t imu_period = 0;
  std::uint64_t odometry_period = 0;
  std::uint64_t battery_period = 0;
  std::uint64_t turn = 0;                 ///< of the lidar
  std::uint64_t ultrasonic_interval = 0;  ///< from ping to ping
  std::vector<exports::Vec3> beams;       ///< along which the points of a turn are taken, in the base frame
};

/// Throws ConfigError where a profile cannot be simulated: a period that is no whole number of steps, or a lidar whose
/// points do not divide evenly among the steps of a turn.
RobotModel make_robot(const RobotProfile& profile);

/// A robot that stands at `pose` as an episode begins.
RobotState begin(const RobotModel& robot, const Pose2D& pose, std::uint64_t seed, std::uint32_t episode);
/// Moves it on by `kStep`, told `sent` at its beginning.
void step(const RobotModel& robot, const Velocity& sent, Physics& physics, RobotState& state);

// What became ready in the last step: readings are complete at the step's end, before any latency.

bool imu_ready(const RobotModel& robot, const RobotState& state);
bool odometry_ready(const RobotModel& robot, const RobotState& state);
bool scan_ready(const RobotModel& robot, const RobotState& state);
/// In the first step too: one reading tells all about a battery, and nobody waits a period for it.
bool battery_ready(const RobotModel& robot, const RobotState& state);
/// The sensor, counted in the order of the profile's mounts, whose ping has just been heard.
std::optional<std::size_t> ping_ready(const RobotModel& robot, const RobotState& state);
/// The points of the turn that just ended, in the order in which they were taken; only while `scan_ready`.
std::span<const float> scan_points(const RobotModel& robot, const RobotState& state);

}  // namespace threewe::backend::mujoco
