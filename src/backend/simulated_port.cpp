#include "backend/simulated_port.hpp"

namespace threewe::backend {
namespace {

SensorInfo sensor_info(SensorType type, Duration period) {
  return {std::string(to_string(type)), type, 1.0 / to_seconds(period)};
}

}  // namespace

Features simulated_features(const RobotProfile& profile, bool with_camera) {
  Features features;
  features.kinematics = profile.kinematics();
  features.lockstep = features.deterministic = features.can_reset = features.can_save = true;
  if (profile.lidar) features.sensors.push_back(sensor_info(SensorType::lidar, profile.lidar->turn));
  if (profile.imu) features.sensors.push_back(sensor_info(SensorType::imu, profile.imu->period));
  features.sensors.push_back(sensor_info(SensorType::odometry, profile.odometry.period));
  if (profile.battery) features.sensors.push_back(sensor_info(SensorType::battery, profile.battery->period));
  if (profile.ultrasonics) {
    for (const UltrasonicSpec::Mount& mount : profile.ultrasonics->mounts) {
      features.sensors.push_back({mount.name, SensorType::ultrasonic, 1.0 / to_seconds(profile.ultrasonics->period())});
    }
  }
  if (profile.camera && with_camera) {
    features.sensors.push_back(sensor_info(SensorType::camera, profile.camera->period));
  }
  return features;
}

}  // namespace threewe::backend
