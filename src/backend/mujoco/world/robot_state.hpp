// What a simulated robot carries beyond its body, which MuJoCo moves. Plain data.
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "backend/mujoco/world/physics.hpp"
#include "threewe/core/rng.hpp"
#include "threewe/core/samples.hpp"
#include "threewe/models/imu.hpp"
#include "threewe/models/odometry.hpp"

namespace threewe::backend::mujoco {

/// The longest command latency that a state has room for [steps].
inline constexpr int kMaxLatencySteps = 16;
/// The most lidar points a turn that a state has room for.
inline constexpr int kMaxLidarPoints = 512;

/// Every member fills 8 bytes or more, so that no padding hides between them.
struct RobotState {
  // which noise it draws
  std::uint64_t seed = 0;
  std::uint64_t episode = 0;
  std::uint64_t steps = 0;  ///< taken since the reset

  Pose2D start;
  double max_collision_speed = 0.0;  ///< [m/s] since the reset
  double distance_driven = 0.0;      ///< [m] since the reset

  std::array<Velocity, kMaxLatencySteps> commands{};  ///< by the step that obeys them, modulo the array's size
  models::WheelErrors wheel_errors;
  BatteryState battery;

  // the sensors: their newest readings, and what they carry on
  IMUData imu;
  models::IMUState imu_state;
  models::OdometryState odometry;
  double ultrasonic_range = 0.0;                      ///< [m] of the newest ping, whichever sensor's it was
  double lidar_bias = 0.0;                            ///< [m]
  std::array<float, kMaxLidarPoints> lidar_points{};  ///< [m] of the turn in progress, or of the one that just ended

  RngKey key(Stream stream, std::uint16_t sensor = 0) const {
    return {seed, static_cast<std::uint32_t>(episode), 0, sensor, stream};
  }
  Time time() const { return static_cast<Duration::rep>(steps) * kStep; }
};
static_assert(std::is_trivially_copyable_v<RobotState>);

}  // namespace threewe::backend::mujoco
