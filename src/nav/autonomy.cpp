#include "nav/autonomy.hpp"

#include <memory>
#include <numbers>

#include "hardware/parameters.hpp"
#include "nav/path_navigator.hpp"
#include "slam/scan_matching_localizer.hpp"

namespace threewe::slam {

SharedParams params_for(const RobotProfile& profile) {
  auto params = threewe::params_for<Params>(profile, "slam");
  params.map_resolution = rounded_resolution(params.map_resolution);
  return std::make_shared<const Params>(params);
}

std::unique_ptr<Localizer> make_localizer(const RobotProfile& profile, const InitialState& initial) {
  constexpr double kUniform = std::numbers::inv_sqrt3;  // deviation of what is uniform in [-1, 1]
  SensorModel sensors;
  sensors.lidar = profile.lidar.has_value();
  sensors.gyro = profile.imu.has_value();
  if (profile.lidar) {
    sensors.base_from_lidar = profile.lidar->base_from_lidar;
    sensors.range_sigma = profile.lidar->sigma;
    sensors.range_bias_sigma = kUniform * profile.lidar->bias;
    sensors.points_per_turn = profile.lidar->points_per_turn;
  }
  if (profile.imu) {
    sensors.gyro_sigma = profile.imu->gyro_sigma;
    sensors.gyro_bias_sigma = kUniform * profile.imu->gyro_bias;
    sensors.gyro_bias_walk = profile.imu->gyro_bias_walk;
  }
  const OdometrySpec& wheels = profile.odometry;
  sensors.forward_scale_sigma = kUniform * wheels.wheel_scale;
  sensors.lateral_scale = 0.5 * (wheels.lateral_scale_min + wheels.lateral_scale_max);
  sensors.lateral_scale_sigma = kUniform * 0.5 * (wheels.lateral_scale_max - wheels.lateral_scale_min);
  return make_scan_matching_localizer(sensors, initial, params_for(profile));
}

}  // namespace threewe::slam

namespace threewe::nav {

std::unique_ptr<Navigator> make_navigator(const RobotProfile& profile) {
  return std::make_unique<PathNavigator>(profile);
}

}  // namespace threewe::nav
