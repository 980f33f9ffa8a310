#include "ros2/publications.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "core/exact.hpp"
#include "ros2/jpeg.hpp"

namespace threewe::ros2 {
namespace {

constexpr std::uint8_t kUltrasound = 0;   // Range: ULTRASOUND
constexpr std::uint8_t kDischarging = 2;  // BatteryState: POWER_SUPPLY_STATUS_DISCHARGING
constexpr std::uint8_t kLithiumIon = 2;   // BatteryState: POWER_SUPPLY_TECHNOLOGY_LION
constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

// As REP 117 has it.
float to_range(double range, double range_max) {
  if (range == 0.0) return std::numeric_limits<float>::quiet_NaN();
  return range >= range_max ? std::numeric_limits<float>::infinity() : static_cast<float>(range);
}

std::array<double, 9> diagonal(double sigma) {
  const double variance = sigma * sigma;
  return {variance, 0.0, 0.0, 0.0, variance, 0.0, 0.0, 0.0, variance};
}

sensor_msgs::Image image_of(const CameraIntrinsics& size, std::string encoding, std::size_t pixel,
                            std_msgs::Header header) {
  sensor_msgs::Image message;
  message.header = std::move(header);
  message.height = static_cast<std::uint32_t>(size.height);
  message.width = static_cast<std::uint32_t>(size.width);
  message.encoding = std::move(encoding);
  message.step = static_cast<std::uint32_t>(pixel) * message.width;
  message.data.resize(std::size_t{message.step} * message.height);
  return message;
}

}  // namespace

builtin_interfaces::Time to_stamp(Time time) {
  constexpr Duration::rep kSecond = 1'000'000'000;
  return {static_cast<std::int32_t>(time.count() / kSecond), static_cast<std::uint32_t>(time.count() % kSecond)};
}

geometry_msgs::Quaternion to_quaternion(double theta) {
  return {0.0, 0.0, exact::sin(0.5 * theta), exact::cos(0.5 * theta)};
}

geometry_msgs::TransformStamped to_transform(Time time, const std::string& parent, const std::string& child,
                                             const Pose2D& parent_from_child) {
  geometry_msgs::TransformStamped transform;
  transform.header = {to_stamp(time), parent};
  transform.child_frame_id = child;
  transform.transform.translation = {parent_from_child.x, parent_from_child.y, 0.0};
  transform.transform.rotation = to_quaternion(parent_from_child.theta);
  return transform;
}

sensor_msgs::LaserScan to_message(const LaserScan& scan, const LidarSpec& spec, std_msgs::Header header) {
  sensor_msgs::LaserScan message;
  message.header = std::move(header);
  const auto last = static_cast<double>(scan.ranges.size()) - 1.0;
  message.angle_min = static_cast<float>(scan.angle_min);
  message.angle_max = static_cast<float>(scan.angle_min + last * scan.angle_increment);
  message.angle_increment = static_cast<float>(scan.angle_increment);
  message.time_increment = static_cast<float>(scan.time_increment);
  message.scan_time = static_cast<float>(to_seconds(spec.turn));
  message.range_min = static_cast<float>(scan.range_min);
  message.range_max = static_cast<float>(scan.range_max);
  message.ranges.reserve(scan.ranges.size());
  for (const float range : scan.ranges) {
    message.ranges.push_back(to_range(static_cast<double>(range), scan.range_max));
  }
  return message;
}

sensor_msgs::Imu to_message(const IMUData& imu, const IMUSpec& spec, std_msgs::Header header) {
  sensor_msgs::Imu message;
  message.header = std::move(header);
  message.orientation_covariance[0] = -1.0;  // there is none
  const auto& w = imu.angular_velocity;
  const auto& a = imu.linear_acceleration;
  message.angular_velocity = {w[0], w[1], w[2]};
  message.angular_velocity_covariance = diagonal(spec.gyro_sigma);
  message.linear_acceleration = {a[0], a[1], a[2]};
  message.linear_acceleration_covariance = diagonal(spec.accelerometer_sigma);
  return message;
}

nav_msgs::Odometry to_message(const Odometry& odometry, const std::string& base_frame, std_msgs::Header header) {
  nav_msgs::Odometry message;
  message.header = std::move(header);
  message.child_frame_id = base_frame;
  message.pose.pose.position = {odometry.pose.x, odometry.pose.y, 0.0};
  message.pose.pose.orientation = to_quaternion(odometry.pose.theta);
  message.twist.twist.linear = {odometry.velocity.vx, odometry.velocity.vy, 0.0};
  message.twist.twist.angular.z = odometry.velocity.omega;
  return message;
}

sensor_msgs::BatteryState to_message(const BatteryState& battery, std_msgs::Header header) {
  sensor_msgs::BatteryState message;
  message.header = std::move(header);
  message.voltage = static_cast<float>(battery.voltage);
  message.current = static_cast<float>(-battery.current);  // ROS counts what flows in
  message.percentage = static_cast<float>(battery.charge);
  message.temperature = message.charge = message.capacity = message.design_capacity = kUnknown;
  message.power_supply_status = kDischarging;
  message.power_supply_technology = kLithiumIon;
  message.present = true;
  return message;
}

sensor_msgs::Range to_message(const RangeData& range, std_msgs::Header header) {
  sensor_msgs::Range message;
  message.header = std::move(header);
  message.radiation_type = kUltrasound;
  message.field_of_view = static_cast<float>(range.field_of_view);
  message.min_range = static_cast<float>(range.range_min);
  message.max_range = static_cast<float>(range.range_max);
  message.range = to_range(range.range, range.range_max);
  return message;
}

sensor_msgs::Image color_message(const RGBDImage& image, std_msgs::Header header) {
  sensor_msgs::Image message = image_of(image.intrinsics, "bgr8", 3, std::move(header));
  message.data = image.color;
  return message;
}

sensor_msgs::CompressedImage compressed_message(const RGBDImage& image, std_msgs::Header header) {
  sensor_msgs::CompressedImage message;
  message.header = std::move(header);
  message.format = "bgr8; jpeg compressed bgr8";  // as image_transport states it
  message.data = encode_jpeg(image.color, {image.intrinsics.width, image.intrinsics.height});
  return message;
}

sensor_msgs::Image depth_message(const RGBDImage& image, std_msgs::Header header) {
  sensor_msgs::Image message = image_of(image.intrinsics, "32FC1", sizeof(float), std::move(header));
  for (std::size_t i = 0; i < image.depth.size(); ++i) {
    const float depth = image.depth[i] == 0.0F ? std::numeric_limits<float>::quiet_NaN() : image.depth[i];
    std::memcpy(message.data.data() + i * sizeof depth, &depth, sizeof depth);
  }
  return message;
}

sensor_msgs::CameraInfo to_message(const CameraIntrinsics& camera, std_msgs::Header header) {
  sensor_msgs::CameraInfo message;
  message.header = std::move(header);
  message.height = static_cast<std::uint32_t>(camera.height);
  message.width = static_cast<std::uint32_t>(camera.width);
  message.distortion_model = "plumb_bob";
  message.d.assign(5, 0.0);
  const double cx = camera.cx - 0.5;
  const double cy = camera.cy - 0.5;
  message.k = {camera.fx, 0.0, cx, 0.0, camera.fy, cy, 0.0, 0.0, 1.0};
  message.r = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
  message.p = {camera.fx, 0.0, cx, 0.0, 0.0, camera.fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0};
  return message;
}

nav_msgs::Path to_message(const std::vector<Vec2>& path, std_msgs::Header header) {
  nav_msgs::Path message;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const std::size_t from = i + 1 < path.size() || i == 0 ? i : i - 1;
    const Vec2 step = path[std::min(from + 1, path.size() - 1)] - path[from];
    auto& stamped = message.poses.emplace_back();
    stamped.header = header;
    stamped.pose.position = {path[i].x, path[i].y, 0.0};
    stamped.pose.orientation = to_quaternion(exact::atan2(step.y, step.x));
  }
  message.header = std::move(header);
  return message;
}

nav_msgs::OccupancyGrid to_message(const map::OccupancyGrid& grid, std_msgs::Header header) {
  nav_msgs::OccupancyGrid message;
  message.info.map_load_time = header.stamp;
  message.header = std::move(header);
  message.info.resolution = static_cast<float>(grid.resolution);
  message.info.width = static_cast<std::uint32_t>(grid.width);
  message.info.height = static_cast<std::uint32_t>(grid.height);
  message.info.origin.position = {grid.origin.x, grid.origin.y, 0.0};
  message.data = grid.data;
  return message;
}

}  // namespace threewe::ros2
