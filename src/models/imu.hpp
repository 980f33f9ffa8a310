// IMU noise model: white noise, and biases that follow a random walk.
#pragma once

#include <array>
#include <cstdint>

#include "core/rng.hpp"
#include "threewe/core/samples.hpp"
#include "threewe/hardware/profile.hpp"
#include "threewe/models/randomization.hpp"

namespace threewe::models {

/// What an inertial unit carries from sample to sample. Plain data.
struct IMUState {
  std::array<double, 3> gyro_bias{};           ///< [rad/s]
  std::array<double, 3> accelerometer_bias{};  ///< [m/s^2]
  std::uint64_t samples = 0;                   ///< taken so far
};

/// The unit as an episode begins.
IMUState start_imu(const IMUSpec& spec, const RngKey& key);

/// Takes one sample of a body that turns at `yaw_rate` [rad/s] and accelerates by `acceleration` [m/s^2, body frame].
/// A variation's `imu_noise` scales scatter and biases, as they are.
IMUData measure_imu(const IMUSpec& spec, const RngKey& key, double yaw_rate, Vec2 acceleration, IMUState& state,
                    const Variation& variation = {});

}  // namespace threewe::models
