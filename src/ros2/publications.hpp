// Conversions of samples of the contract to ROS 2 messages, the inverse of readings.hpp.
#pragma once

#include "ros2/messages/nav_msgs.hpp"
#include "ros2/messages/sensor_msgs.hpp"
#include "ros2/messages/system_msgs.hpp"
#include "threewe/core/samples.hpp"
#include "threewe/hardware/profile.hpp"
#include "threewe/map/occupancy_grid.hpp"

namespace threewe::ros2 {

/// A time as a stamp.
builtin_interfaces::Time to_stamp(Time time);
/// A rotation about the vertical axis.
geometry_msgs::Quaternion to_quaternion(double theta);
/// `parent_from_child` as a transform along the floor.
geometry_msgs::TransformStamped to_transform(Time time, const std::string& parent, const std::string& child,
                                             const Pose2D& parent_from_child);

/// Counter-clockwise, stamped with beam 0; inf is no return and nan invalid, as REP 117 has them.
sensor_msgs::LaserScan to_message(const LaserScan& scan, const LidarSpec& spec, std_msgs::Header header);
/// Without an orientation.
sensor_msgs::Imu to_message(const IMUData& imu, const IMUSpec& spec, std_msgs::Header header);
nav_msgs::Odometry to_message(const Odometry& odometry, const std::string& base_frame, std_msgs::Header header);
sensor_msgs::BatteryState to_message(const BatteryState& battery, std_msgs::Header header);
sensor_msgs::Range to_message(const RangeData& range, std_msgs::Header header);
/// The colours, in bgr8.
sensor_msgs::Image color_message(const RGBDImage& image, std_msgs::Header header);
/// The colours as a JPEG. Throws ContractError where libjpeg-turbo is missing.
sensor_msgs::CompressedImage compressed_message(const RGBDImage& image, std_msgs::Header header);
/// The depths [m], in 32FC1; nan is invalid (REP 118).
sensor_msgs::Image depth_message(const RGBDImage& image, std_msgs::Header header);
/// In ROS's convention: the middle of the first pixel is at (0, 0), not at (0.5, 0.5).
sensor_msgs::CameraInfo to_message(const CameraIntrinsics& camera, std_msgs::Header header);
/// Each point heads for the next.
nav_msgs::Path to_message(const std::vector<Vec2>& path, std_msgs::Header header);
nav_msgs::OccupancyGrid to_message(const map::OccupancyGrid& grid, std_msgs::Header header);

}  // namespace threewe::ros2
