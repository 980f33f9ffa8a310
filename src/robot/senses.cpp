#include "robot/senses.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "threewe/core/errors.hpp"
#include "threewe/core/exact.hpp"

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

// What is wrong with the size of finite data; nothing when all is well. Far beyond any robot: it keeps one mad value
// from overflowing what is computed from it.
const char* excess(const SampleData& data) {
  const auto beyond = [](double value, double limit) { return std::abs(value) > limit; };
  constexpr double kMaxCoordinate = 1e6;  // [m]
  constexpr double kMaxSpeed = 1e3;       // [m/s] or [rad/s]
  constexpr double kMaxSweep = 10.0;      // [s]
  if (const auto* scan = std::get_if<LaserScan>(&data)) {
    if (beyond(scan->angle_min, 2.0 * exact::kPi)) return "angle_min is beyond +-2 pi rad";
    if (beyond(scan->angle_increment, 2.0 * exact::kPi)) return "angle_increment is beyond +-2 pi rad";
    const double sweep = scan->time_increment * static_cast<double>(scan->ranges.size());
    if (beyond(sweep, kMaxSweep)) return "time_increment makes a scan longer than 10 s";
  } else if (const auto* imu = std::get_if<IMUData>(&data)) {
    for (const double rate : imu->angular_velocity) {
      if (beyond(rate, kMaxSpeed)) return "angular_velocity is beyond +-1000 rad/s";
    }
  } else if (const auto* odometry = std::get_if<Odometry>(&data)) {
    const Pose2D& pose = odometry->pose;
    const Velocity& v = odometry->velocity;
    if (beyond(pose.x, kMaxCoordinate) || beyond(pose.y, kMaxCoordinate)) return "pose is beyond +-1000 km";
    if (beyond(v.vx, kMaxSpeed) || beyond(v.vy, kMaxSpeed)) return "velocity is beyond +-1000 m/s";
    if (beyond(v.omega, kMaxSpeed)) return "velocity is beyond +-1000 rad/s";
  }
  return nullptr;
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
  if (const char* what = excess(sample.data)) refuse(what);
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
