#include "robot/senses.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "threewe/core/errors.hpp"

namespace threewe {
namespace {

const char* name_of(SensorType type) {
  switch (type) {
    case SensorType::lidar: return "lidar";
    case SensorType::imu: return "imu";
    case SensorType::odometry: return "odometry";
    case SensorType::battery: return "battery";
  }
  return "sensor";
}

bool all_finite(const SampleData& data) {
  struct Visitor {
    bool operator()(const LaserScan& scan) const {
      return std::isfinite(scan.angle_min) && std::isfinite(scan.angle_increment) &&
             std::isfinite(scan.time_increment) && std::isfinite(scan.range_max) &&
             std::all_of(scan.ranges.begin(), scan.ranges.end(), [](float r) { return std::isfinite(r); });
    }
    bool operator()(const IMUData& imu) const {
      const auto finite = [](double v) { return std::isfinite(v); };
      return std::all_of(imu.angular_velocity.begin(), imu.angular_velocity.end(), finite) &&
             std::all_of(imu.linear_acceleration.begin(), imu.linear_acceleration.end(), finite);
    }
    bool operator()(const Odometry& odometry) const { return is_finite(odometry.pose) && is_finite(odometry.velocity); }
    bool operator()(const BatteryState& battery) const {
      return std::isfinite(battery.voltage) && std::isfinite(battery.current) && std::isfinite(battery.charge);
    }
  };
  return std::visit(Visitor{}, data);
}

}  // namespace

void check_sample(const backend::Features& features, const Sample& sample) {
  if (sample.sensor >= features.sensors.size()) {
    throw ContractError("a sample names sensor " + std::to_string(sample.sensor) + ", but the robot has " +
                        std::to_string(features.sensors.size()));
  }
  const backend::SensorInfo& sensor = features.sensors[sample.sensor];
  const auto refuse = [&](const char* what) {
    throw ContractError("sensor '" + sensor.name + "', sample " + std::to_string(sample.sequence) + ": " + what);
  };
  if (sample.data.index() != static_cast<std::size_t>(sensor.type)) refuse("its data are of another type of sensor");
  if (sample.measured > sample.received) refuse("it was measured after it was received");
  if (!all_finite(sample.data)) refuse("its data are not finite");
}

const Sample& Senses::newest(const backend::Features& features, const RobotProfile& profile, SensorType type) const {
  for (std::size_t i = 0; i < features.sensors.size(); ++i) {
    if (features.sensors[i].type != type) continue;
    if (newest_[i]) return *newest_[i];
    throw HardwareError("sensor '" + features.sensors[i].name + "' has not delivered anything yet");
  }
  throw HardwareError("robot '" + profile.name + "' has no sensor '" + name_of(type) + "'");
}

bool Senses::complete() const {
  return std::all_of(newest_.begin(), newest_.end(), [](const auto& sample) { return sample.has_value(); });
}

}  // namespace threewe
