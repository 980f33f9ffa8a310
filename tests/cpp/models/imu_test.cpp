#include "models/imu.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

using namespace threewe;
using namespace threewe::models;

namespace {

IMUSpec bmi160() { return *load_profile("3we_standard_v2").imu; }

}  // namespace

TEST_CASE("a perfect unit measures the truth: turning left is positive, and gravity points up at rest") {
  const IMUSpec spec{.period = 10ms};
  IMUState state = start_imu(spec, {});
  const IMUData data = measure_imu(spec, {}, 0.7, {1.5, -0.5}, state);
  CHECK(data.angular_velocity == std::array<double, 3>{0.0, 0.0, 0.7});
  CHECK(data.linear_acceleration[0] == 1.5);
  CHECK(data.linear_acceleration[1] == -0.5);
  CHECK(data.linear_acceleration[2] == doctest::Approx(9.81).epsilon(0.001));
}

TEST_CASE("scatter has the stated size on every axis, whatever the motion") {
  IMUSpec spec = bmi160();
  spec.gyro_bias = spec.gyro_bias_walk = spec.accelerometer_bias = 0.0;
  const RngKey key{.seed = 8, .stream = Stream::imu};
  IMUState state = start_imu(spec, key);
  constexpr int kCount = 50'000;
  std::array<double, 3> gyro{};
  std::array<double, 3> force{};
  for (int i = 0; i < kCount; ++i) {
    const IMUData data = measure_imu(spec, key, 1.0, {2.0, 3.0}, state);
    const std::array<double, 3> rate{0.0, 0.0, 1.0};
    const std::array<double, 3> pull{2.0, 3.0, 9.80665};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      gyro[axis] += std::pow(data.angular_velocity[axis] - rate[axis], 2);
      force[axis] += std::pow(data.linear_acceleration[axis] - pull[axis], 2);
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    CHECK(std::sqrt(gyro[axis] / kCount) == doctest::Approx(spec.gyro_sigma).epsilon(0.02));
    CHECK(std::sqrt(force[axis] / kCount) == doctest::Approx(spec.accelerometer_sigma).epsilon(0.02));
  }
}

TEST_CASE("the bias starts within half a degree per second and walks as the square root of time") {
  IMUSpec spec = bmi160();
  CHECK(spec.gyro_bias == doctest::Approx(0.5 * M_PI / 180).epsilon(1e-3));
  spec.gyro_sigma = 0.0;
  double squares = 0.0;
  constexpr int kUnits = 400;
  for (std::uint64_t seed = 0; seed < kUnits; ++seed) {
    const RngKey key{.seed = seed, .stream = Stream::imu};
    IMUState state = start_imu(spec, key);
    const std::array<double, 3> at_start = state.gyro_bias;
    for (const double bias : at_start) CHECK(std::fabs(bias) <= spec.gyro_bias);
    for (int i = 0; i < 1000; ++i) measure_imu(spec, key, 0.0, {}, state);
    squares += std::pow(state.gyro_bias[2] - at_start[2], 2);
  }
  // 10 s
  CHECK(std::sqrt(squares / kUnits) == doctest::Approx(spec.gyro_bias_walk * std::sqrt(10.0)).epsilon(0.12));
}

TEST_CASE("each switch changes that one thing") {
  const RngKey key{.seed = 4, .stream = Stream::imu};
  const auto samples = [&](const IMUSpec& spec) {
    IMUState state = start_imu(spec, key);
    std::vector<IMUData> taken;
    taken.reserve(100);
    for (int i = 0; i < 100; ++i) taken.push_back(measure_imu(spec, key, 0.5, {1.0, 0.0}, state));
    return taken;
  };
  const auto real = samples(bmi160());
  IMUSpec spec = bmi160();
  spec.gyro_sigma = 0.0;
  const auto no_gyro_scatter = samples(spec);
  spec = bmi160();
  spec.gyro_bias_walk = 0.0;
  const auto no_walk = samples(spec);
  spec = bmi160();
  spec.accelerometer_sigma = 0.0;
  const auto no_force_scatter = samples(spec);
  for (std::size_t i = 0; i < real.size(); ++i) {
    CHECK(no_gyro_scatter[i].linear_acceleration == real[i].linear_acceleration);
    CHECK(no_gyro_scatter[i].angular_velocity != real[i].angular_velocity);
    CHECK(no_walk[i].linear_acceleration == real[i].linear_acceleration);
    CHECK((no_walk[i].angular_velocity == real[i].angular_velocity) == (i == 0));
    CHECK(no_force_scatter[i].angular_velocity == real[i].angular_velocity);
    CHECK(no_force_scatter[i].linear_acceleration != real[i].linear_acceleration);
  }
}
