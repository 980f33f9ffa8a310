#include "backend/plugin_checks.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "threewe/core/errors.hpp"
#include "threewe/core/exact.hpp"
#include "threewe/core/names.hpp"

namespace threewe::backend {

namespace {

constexpr double kMaxCoordinate = 1e6;    // [m], of a pose
constexpr double kMaxSpeed = 1e3;         // [m/s] or [rad/s]
constexpr double kMaxSweep = 10.0;        // [s], of one scan
constexpr double kRangeTolerance = 1e-4;  // [m], of a range kept as a float

/// One reading under check: knows how to complain.
struct Reading {
  const std::string& sensor;

  template <typename... Args>
  [[noreturn]] void fail(const char* field, fmt::format_string<Args...> what, Args&&... args) const {
    throw ContractError(
        fmt::format("sensor '{}': {} {}", sensor, field, fmt::format(what, std::forward<Args>(args)...)));
  }
  void finite(const char* field, double value) const {
    if (!std::isfinite(value)) fail(field, "is {}; it must be finite", value);
  }
  void within(const char* field, double value, double limit, const char* unit) const {
    finite(field, value);
    if (std::abs(value) > limit) fail(field, "is {}; it must be within +-{} {}", value, limit, unit);
  }
};

void check(const Reading& reading, const LaserScan& scan, const RobotProfile& profile) {
  const LidarSpec& spec = *profile.lidar;
  reading.within("angle_min", scan.angle_min, 2.0 * exact::kPi, "rad");
  reading.within("time_increment", scan.time_increment, kMaxSweep / spec.beams, "s");
  if (scan.ranges.size() != static_cast<std::size_t>(spec.beams)) {
    reading.fail("ranges", "has shape ({},); the profile '{}' has ({},)", scan.ranges.size(), profile.name, spec.beams);
  }
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const auto range = static_cast<double>(scan.ranges[i]);
    const bool within = range >= spec.range_min - kRangeTolerance && range <= spec.range_max + kRangeTolerance;
    if (range == 0.0 || within) continue;
    reading.fail("ranges", "[{}] is {}; it must be 0 (invalid) or within {} to {} m (no return: {})", i, range,
                 spec.range_min, spec.range_max, spec.range_max);
  }
}

void check(const Reading& reading, const IMUData& imu, const RobotProfile&) {
  for (const double value : imu.angular_velocity) reading.within("angular_velocity", value, kMaxSpeed, "rad/s");
  for (const double value : imu.linear_acceleration) reading.finite("linear_acceleration", value);
}

void check(const Reading& reading, const Odometry& odometry, const RobotProfile&) {
  for (const double value : {odometry.pose.x, odometry.pose.y}) reading.within("pose", value, kMaxCoordinate, "m");
  reading.finite("pose", odometry.pose.theta);
  const Velocity& v = odometry.velocity;
  for (const double value : {v.vx, v.vy}) reading.within("velocity", value, kMaxSpeed, "m/s");
  reading.within("velocity", v.omega, kMaxSpeed, "rad/s");
  const double theta = odometry.pose.theta;
  if (theta <= -exact::kPi || theta > exact::kPi) {
    reading.fail("pose", "has a heading of {}, outside (-pi, pi]", theta);
  }
}

void check(const Reading& reading, const BatteryState& battery, const RobotProfile&) {
  reading.finite("voltage", battery.voltage);
  reading.finite("current", battery.current);
  reading.finite("charge", battery.charge);
  if (battery.charge < 0.0 || battery.charge > 1.0) {
    reading.fail("charge", "is {}; it must be within 0 to 1", battery.charge);
  }
}

}  // namespace

void check_features(const std::string& name, const Features& features, const RobotProfile& profile) {
  const auto fail = [&name](const std::string& what) {
    throw ContractError(fmt::format("backend '{}': {}", name, what));
  };
  if (features.can_save && !features.lockstep) fail("can be saved, but time runs by itself");
  if (features.kinematics != profile.kinematics()) fail("features and profile differ in their kinematics");
  for (const SensorInfo& sensor : features.sensors) {
    const auto same_name = [&sensor](const SensorInfo& other) { return other.name == sensor.name; };
    if (std::count_if(features.sensors.begin(), features.sensors.end(), same_name) > 1) {
      fail(fmt::format("two sensors are named '{}'", sensor.name));
    }
    if (!std::isfinite(sensor.rate) || sensor.rate <= 0.0) {
      fail(fmt::format("sensor '{}': rate is {} Hz; it must be positive", sensor.name, sensor.rate));
    }
    const bool in_profile =
        sensor.type == SensorType::odometry || (sensor.type == SensorType::lidar && profile.lidar) ||
        (sensor.type == SensorType::imu && profile.imu) || (sensor.type == SensorType::battery && profile.battery);
    if (!in_profile) fail(fmt::format("sensor '{}': the profile '{}' has none", sensor.name, profile.name));
  }
}

std::size_t find_sensor(const Features& features, const std::string& name) {
  std::vector<std::string> names;
  names.reserve(features.sensors.size());
  for (const SensorInfo& sensor : features.sensors) names.push_back(sensor.name);
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) throw ContractError(unknown_name("sensor", name, names));
  return static_cast<std::size_t>(found - names.begin());
}

void check_reading(const PluginReading& reading, SensorType type, const RobotProfile& profile) {
  if (reading.data.index() != static_cast<std::size_t>(type)) {
    throw ContractError(fmt::format("sensor '{}': another kind of data than it measures", reading.sensor));
  }
  std::visit([&](const auto& data) { check(Reading{reading.sensor}, data, profile); }, reading.data);
}

void check_stamp(const PluginReading& reading, Time newest, Time latest) {
  if (reading.measured > latest) {
    Reading{reading.sensor}.fail("measured", "is {} s, in the future: now is {} s", to_seconds(reading.measured),
                                 to_seconds(latest));
  }
  if (reading.measured <= newest) {
    Reading{reading.sensor}.fail("measured", "is {} s, not after {} s of the reading before",
                                 to_seconds(reading.measured), to_seconds(newest));
  }
}

}  // namespace threewe::backend
