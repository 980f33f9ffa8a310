#include "models/imu.hpp"

#include "core/exact.hpp"
#include "models/drive.hpp"

namespace threewe::models {
namespace {

// The lanes of one sample's draws, three axes each; the order is part of the recorded format.
enum Lane : std::uint32_t { kGyro = 0, kAccelerometer = 3, kWalk = 6 };

double scatter(double sigma, const RngKey& key, std::uint64_t sample, std::uint32_t lane) {
  return sigma > 0.0 ? sigma * normal(key, sample, lane) : 0.0;
}

}  // namespace

IMUState start_imu(const IMUSpec& spec, const RngKey& key) {
  RngKey episode = key;
  episode.stream = Stream::episode;
  const auto draw = static_cast<std::uint64_t>(Stream::imu);
  IMUState state;
  for (std::uint32_t axis = 0; axis < 3; ++axis) {
    state.gyro_bias[axis] = uniform(episode, draw, kGyro + axis, -spec.gyro_bias, spec.gyro_bias);
    state.accelerometer_bias[axis] =
        uniform(episode, draw, kAccelerometer + axis, -spec.accelerometer_bias, spec.accelerometer_bias);
  }
  return state;
}

IMUData measure_imu(const IMUSpec& spec, const RngKey& key, double yaw_rate, Vec2 acceleration, IMUState& state,
                    const Variation& variation) {
  const std::array<double, 3> rate{0.0, 0.0, yaw_rate};
  const std::array<double, 3> force{acceleration.x, acceleration.y, kGravity};
  const std::uint64_t sample = state.samples++;
  const double walk = spec.gyro_bias_walk > 0.0 ? spec.gyro_bias_walk * exact::sqrt(to_seconds(spec.period)) : 0.0;
  const double noise = variation.imu_noise;
  IMUData data;
  for (std::uint32_t axis = 0; axis < 3; ++axis) {
    data.angular_velocity[axis] =
        rate[axis] + noise * state.gyro_bias[axis] + scatter(noise * spec.gyro_sigma, key, sample, kGyro + axis);
    data.linear_acceleration[axis] = force[axis] + noise * state.accelerometer_bias[axis] +
                                     scatter(noise * spec.accelerometer_sigma, key, sample, kAccelerometer + axis);
    state.gyro_bias[axis] += scatter(walk, key, sample, kWalk + axis);
  }
  return data;
}

}  // namespace threewe::models
