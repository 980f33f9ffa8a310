// Simulation state as plain data: copied, saved, restored and compared as bytes.
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "core/rng.hpp"
#include "models/drive.hpp"
#include "models/imu.hpp"
#include "models/odometry.hpp"
#include "sim/model.hpp"
#include "threewe/core/kinematics.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/samples.hpp"
#include "threewe/models/randomization.hpp"

namespace threewe::sim {

/// One robot. Every member fills 8 bytes or more, so that no padding hides between them.
struct RobotState {
  // which noise it draws
  std::uint64_t seed = 0;
  std::uint32_t episode = 0;
  std::uint32_t robot = 0;
  std::uint64_t steps = 0;  ///< taken since the reset

  // the body, in the scene's frame
  Pose2D pose;
  Velocity velocity;
  double max_collision_speed = 0.0;  ///< [m/s] since the reset
  double distance_driven = 0.0;      ///< [m] since the reset

  // the drive
  WheelSpeeds wheel_speeds{};            ///< [rad/s]
  std::array<double, 4> wheel_angles{};  ///< [rad] turned since the reset
  models::WheelErrors wheel_errors;
  BatteryState battery;

  // how this robot differs from its profile in this episode, and what follows from that
  models::Traction traction;
  double battery_resistance = 0.0;    ///< [ohm]
  std::uint64_t command_latency = 0;  ///< [steps]
  models::OdometryState odometry;     ///< the encoders' newest reading; what a drive needs ends here
  models::Variation variation;

  Pose2D start;
  std::array<Velocity, kMaxLatencySteps> commands{};  ///< by the step that obeys them, modulo the array's size

  // the sensors: their newest readings, and what they carry on
  IMUData imu;
  models::IMUState imu_state;
  double ultrasonic_range = 0.0;                      ///< [m] of the newest ping, whichever sensor's it was
  double lidar_bias = 0.0;                            ///< [m]
  std::array<float, kMaxLidarPoints> lidar_points{};  ///< [m] of the turn in progress, or of the one that just ended

  RngKey key(Stream stream) const { return {seed, episode, static_cast<std::uint16_t>(robot), 0, stream}; }
  Time time() const { return static_cast<Duration::rep>(steps) * kStep; }
};

static_assert(std::is_trivially_copyable_v<RobotState>);
static_assert(sizeof(RobotState) == 4 * sizeof(std::uint64_t) + 3 * sizeof(Pose2D) + 5 * sizeof(double) +
                                        2 * sizeof(WheelSpeeds) + sizeof(models::WheelErrors) + sizeof(BatteryState) +
                                        sizeof(models::Traction) + sizeof(models::Variation) +
                                        sizeof(std::array<Velocity, kMaxLatencySteps>) + sizeof(IMUData) +
                                        sizeof(models::IMUState) + sizeof(models::OdometryState) +
                                        sizeof(std::array<float, kMaxLidarPoints>),
              "a gap between members would hold bytes that nothing sets");

}  // namespace threewe::sim
