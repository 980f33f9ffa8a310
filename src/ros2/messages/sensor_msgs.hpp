// ROS 2 messages of sensor_msgs.
#pragma once

#include "ros2/messages/geometry_msgs.hpp"

namespace threewe::ros2::sensor_msgs {

struct LaserScan {
  static constexpr std::string_view kType = "sensor_msgs/msg/LaserScan";
  std_msgs::Header header;
  float angle_min = 0.0F;
  float angle_max = 0.0F;
  float angle_increment = 0.0F;
  float time_increment = 0.0F;
  float scan_time = 0.0F;
  float range_min = 0.0F;
  float range_max = 0.0F;
  std::vector<float> ranges;
  std::vector<float> intensities;
  static void members(auto& self, auto&& member) {
    member("header", self.header);
    member("angle_min", self.angle_min);
    member("angle_max", self.angle_max);
    member("angle_increment", self.angle_increment);
    member("time_increment", self.time_increment);
    member("scan_time", self.scan_time);
    member("range_min", self.range_min);
    member("range_max", self.range_max);
    member("ranges", self.ranges);
    member("intensities", self.intensities);
  }
};

struct Imu {
  static constexpr std::string_view kType = "sensor_msgs/msg/Imu";
  std_msgs::Header header;
  geometry_msgs::Quaternion orientation;
  std::array<double, 9> orientation_covariance{};
  geometry_msgs::Vector3 angular_velocity;
  std::array<double, 9> angular_velocity_covariance{};
  geometry_msgs::Vector3 linear_acceleration;
  std::array<double, 9> linear_acceleration_covariance{};
  static void members(auto& self, auto&& member) {
    member("header", self.header);
    member("orientation", self.orientation);
    member("orientation_covariance", self.orientation_covariance);
    member("angular_velocity", self.angular_velocity);
    member("angular_velocity_covariance", self.angular_velocity_covariance);
    member("linear_acceleration", self.linear_acceleration);
    member("linear_acceleration_covariance", self.linear_acceleration_covariance);
  }
};

/// `variance` came with Jazzy.
struct Range {
  static constexpr std::string_view kType = "sensor_msgs/msg/Range";
  std_msgs::Header header;
  std::uint8_t radiation_type = 0;
  float field_of_view = 0.0F;
  float min_range = 0.0F;
  float max_range = 0.0F;
  float range = 0.0F;
  float variance = 0.0F;
  static void members(auto& self, auto&& member) {
    member("header", self.header);
    member("radiation_type", self.radiation_type);
    member("field_of_view", self.field_of_view);
    member("min_range", self.min_range);
    member("max_range", self.max_range);
    member("range", self.range);
    if (member.layout != Distribution::humble) member("variance", self.variance);
  }
};

struct BatteryState {
  static constexpr std::string_view kType = "sensor_msgs/msg/BatteryState";
  std_msgs::Header header;
  float voltage = 0.0F;
  float temperature = 0.0F;
  float current = 0.0F;
  float charge = 0.0F;
  float capacity = 0.0F;
  float design_capacity = 0.0F;
  float percentage = 0.0F;
  std::uint8_t power_supply_status = 0;
  std::uint8_t power_supply_health = 0;
  std::uint8_t power_supply_technology = 0;
  bool present = false;
  std::vector<float> cell_voltage;
  std::vector<float> cell_temperature;
  std::string location;
  std::string serial_number;
  static void members(auto& self, auto&& member) {
    member("header", self.header);
    member("voltage", self.voltage);
    member("temperature", self.temperature);
    member("current", self.current);
    member("charge", self.charge);
    member("capacity", self.capacity);
    member("design_capacity", self.design_capacity);
    member("percentage", self.percentage);
    member("power_supply_status", self.power_supply_status);
    member("power_supply_health", self.power_supply_health);
    member("power_supply_technology", self.power_supply_technology);
    member("present", self.present);
    member("cell_voltage", self.cell_voltage);
    member("cell_temperature", self.cell_temperature);
    member("location", self.location);
    member("serial_number", self.serial_number);
  }
};

struct Image {
  static constexpr std::string_view kType = "sensor_msgs/msg/Image";
  std_msgs::Header header;
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  std::string encoding;
  std::uint8_t is_bigendian = 0;
  std::uint32_t step = 0;
  std::vector<std::uint8_t> data;
  static void members(auto& self, auto&& member) {
    member("header", self.header);
    member("height", self.height);
    member("width", self.width);
    member("encoding", self.encoding);
    member("is_bigendian", self.is_bigendian);
    member("step", self.step);
    member("data", self.data);
  }
};

struct CompressedImage {
  static constexpr std::string_view kType = "sensor_msgs/msg/CompressedImage";
  std_msgs::Header header;
  std::string format;
  std::vector<std::uint8_t> data;
  static void members(auto& self, auto&& member) {
    member("header", self.header);
    member("format", self.format);
    member("data", self.data);
  }
};

struct RegionOfInterest {
  static constexpr std::string_view kType = "sensor_msgs/msg/RegionOfInterest";
  std::uint32_t x_offset = 0;
  std::uint32_t y_offset = 0;
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  bool do_rectify = false;
  static void members(auto& self, auto&& member) {
    member("x_offset", self.x_offset);
    member("y_offset", self.y_offset);
    member("height", self.height);
    member("width", self.width);
    member("do_rectify", self.do_rectify);
  }
};

struct CameraInfo {
  static constexpr std::string_view kType = "sensor_msgs/msg/CameraInfo";
  std_msgs::Header header;
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  std::string distortion_model;
  std::vector<double> d;
  std::array<double, 9> k{};
  std::array<double, 9> r{};
  std::array<double, 12> p{};
  std::uint32_t binning_x = 0;
  std::uint32_t binning_y = 0;
  RegionOfInterest roi;
  static void members(auto& self, auto&& member) {
    member("header", self.header);
    member("height", self.height);
    member("width", self.width);
    member("distortion_model", self.distortion_model);
    member("d", self.d);
    member("k", self.k);
    member("r", self.r);
    member("p", self.p);
    member("binning_x", self.binning_x);
    member("binning_y", self.binning_y);
    member("roi", self.roi);
  }
};

struct PointField {
  static constexpr std::string_view kType = "sensor_msgs/msg/PointField";
  std::string name;
  std::uint32_t offset = 0;
  std::uint8_t datatype = 0;
  std::uint32_t count = 0;
  static void members(auto& self, auto&& member) {
    member("name", self.name);
    member("offset", self.offset);
    member("datatype", self.datatype);
    member("count", self.count);
  }
};

struct PointCloud2 {
  static constexpr std::string_view kType = "sensor_msgs/msg/PointCloud2";
  std_msgs::Header header;
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  std::vector<PointField> fields;
  bool is_bigendian = false;
  std::uint32_t point_step = 0;
  std::uint32_t row_step = 0;
  std::vector<std::uint8_t> data;
  bool is_dense = false;
  static void members(auto& self, auto&& member) {
    member("header", self.header);
    member("height", self.height);
    member("width", self.width);
    member("fields", self.fields);
    member("is_bigendian", self.is_bigendian);
    member("point_step", self.point_step);
    member("row_step", self.row_step);
    member("data", self.data);
    member("is_dense", self.is_dense);
  }
};

}  // namespace threewe::ros2::sensor_msgs
