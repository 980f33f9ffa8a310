#include "hardware/sample_checks.hpp"

#include <cmath>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "core/exact.hpp"
#include "threewe/core/errors.hpp"

namespace threewe {
namespace {

// One reading under check: knows how to complain.
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
  reading.within("angle_increment", scan.angle_increment, 2.0 * exact::kPi, "rad");
  reading.finite("range_min", scan.range_min);
  reading.finite("range_max", scan.range_max);
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

void check(const Reading& reading, const RangeData& echo, const RobotProfile& profile) {
  const UltrasonicSpec& spec = *profile.ultrasonics;
  reading.within("field_of_view", echo.field_of_view, exact::kPi, "rad");
  reading.finite("range_min", echo.range_min);
  reading.finite("range_max", echo.range_max);
  const bool within = echo.range >= spec.range_min - kRangeTolerance && echo.range <= spec.range_max + kRangeTolerance;
  if (echo.range == 0.0 || within) return;
  reading.fail("range", "is {}; it must be 0 (invalid) or within {} to {} m (no return: {})", echo.range,
               spec.range_min, spec.range_max, spec.range_max);
}

void check(const Reading& reading, const Picture& picture, const RobotProfile& profile) {
  if (!picture.is_drawn()) return;  // our own, drawn when it is looked at
  const CameraSpec& spec = *profile.camera;
  const RGBDImage& image = picture.image();
  const auto [width, height] = std::pair(spec.width, spec.height);
  const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  if (image.intrinsics.width != width || image.intrinsics.height != height || image.color.size() != 3 * pixels) {
    reading.fail("color", "has shape ({}, {}, 3); the profile '{}' has ({}, {}, 3)", image.intrinsics.height,
                 image.intrinsics.width, profile.name, height, width);
  }
  if (image.depth.size() != (spec.depth ? pixels : 0)) {
    reading.fail("depth", "has {} pixels; the profile '{}' has {}", image.depth.size(), profile.name,
                 spec.depth ? pixels : 0);
  }
  for (const float depth : image.depth) {
    const auto metres = static_cast<double>(depth);
    const bool within =
        metres >= spec.depth->range_min - kRangeTolerance && metres <= spec.depth->range_max + kRangeTolerance;
    if (metres == 0.0 || within) continue;
    reading.fail("depth", "holds {}; it must be 0 (invalid) or within {} to {} m", metres, spec.depth->range_min,
                 spec.depth->range_max);
  }
}

}  // namespace

namespace {

void check_kind(const SensorInfo& sensor, const SampleData& data) {
  if (data.index() == static_cast<std::size_t>(sensor.type)) return;
  throw ContractError(fmt::format("sensor '{}': another kind of data than it measures", sensor.name));
}

}  // namespace

void check_data(const SensorInfo& sensor, const SampleData& data, const RobotProfile& profile) {
  check_kind(sensor, data);
  std::visit([&](const auto& measured) { check(Reading{sensor.name}, measured, profile); }, data);
}

void check_kind(std::span<const SensorInfo> sensors, const Sample& sample) {
  if (sample.sensor >= sensors.size()) {
    throw ContractError(fmt::format("a sample names sensor {}, but the robot has {}", sample.sensor, sensors.size()));
  }
  check_kind(sensors[sample.sensor], sample.data);
}

void check_sample(std::span<const SensorInfo> sensors, const Sample& sample, const RobotProfile& profile) {
  check_kind(sensors, sample);
  const SensorInfo& sensor = sensors[sample.sensor];
  if (sample.measured > sample.received) {
    throw ContractError(
        fmt::format("sensor '{}': sample {} was measured after it was received", sensor.name, sample.sequence));
  }
  check_data(sensor, sample.data, profile);
}

}  // namespace threewe
