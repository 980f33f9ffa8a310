// Sensor samples: laser scan, IMU, odometry, battery, range and image, with their stamps.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "threewe/core/camera.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"

namespace threewe {

/// One turn of a planar lidar. Beam i points along `angle_min + i * angle_increment`, counter-clockwise, in the
/// sensor's frame, and was measured at `measured + i * time_increment` (negative for a device that turns clockwise).
struct LaserScan {
  double angle_min = 0.0;        ///< [rad]
  double angle_increment = 0.0;  ///< [rad], positive
  double time_increment = 0.0;   ///< [s]
  double range_min = 0.0;        ///< [m]
  double range_max = 0.0;        ///< [m]
  std::vector<float> ranges;     ///< [m], shape (N,); no return = range_max, invalid = 0.0
};

/// One reading of the inertial unit, in the robot's base frame.
struct IMUData {
  std::array<double, 3> angular_velocity{};     ///< [rad/s] about x, y, z
  std::array<double, 3> linear_acceleration{};  ///< [m/s^2] along x, y, z, gravity included (+9.81 on z at rest)
};

/// Pose in `odom` and body velocity, from the wheels alone.
struct Odometry {
  Pose2D pose;        ///< in `odom`
  Velocity velocity;  ///< in the body frame
};

/// The state of the battery.
struct BatteryState {
  double voltage = 0.0;  ///< [V]
  double current = 0.0;  ///< [A], positive when discharging
  double charge = 0.0;   ///< the fraction left, 0 to 1
};

/// One reading of a sensor that tells the distance to something within a cone, but not where in it. (ROS: a
/// `sensor_msgs/Range`.)
struct RangeData {
  double field_of_view = 0.0;  ///< [rad] from edge to edge of the cone
  double range_min = 0.0;      ///< [m]
  double range_max = 0.0;      ///< [m]
  double range = 0.0;          ///< [m]; no return = range_max, invalid = 0.0
};

/// The kinds of sensor that the contract knows, in the order of `SampleData`.
enum class SensorType : std::uint8_t { lidar, imu, odometry, battery, ultrasonic, camera };
/// Its name, as in `Features`.
std::string_view to_string(SensorType type);

/// One sensor of a robot, as it is known before connecting.
struct SensorInfo {
  std::string name;   ///< "lidar", "imu", "odometry", "battery", a mount of the ultrasonics; unique on a robot
  SensorType type{};  ///< what it measures
  double rate = 0.0;  ///< [Hz]
};

/// A reading of any kind.
using SampleData = std::variant<LaserScan, IMUData, Odometry, BatteryState, RangeData, Picture>;

/// A reading with its stamps. `received` is the robot time at which `poll()` handed it over.
struct Sample {
  std::uint16_t sensor = 0;    ///< index into `Features::sensors`
  std::uint64_t sequence = 0;  ///< counts each sensor's samples from 0, without gaps
  Time measured{};             ///< when it was taken (for a scan, beam 0 of the array)
  Time received{};             ///< when `poll` handed it over
  SampleData data;             ///< the reading itself
};

}  // namespace threewe
