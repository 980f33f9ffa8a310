// ROS 2 messages of nav_msgs.
#pragma once

#include "ros2/messages/geometry_msgs.hpp"

namespace threewe::ros2::nav_msgs {

struct Odometry {
  static constexpr std::string_view kType = "nav_msgs/msg/Odometry";
  std_msgs::Header header;
  std::string child_frame_id;
  geometry_msgs::PoseWithCovariance pose;
  geometry_msgs::TwistWithCovariance twist;
  static void members(auto& self, auto&& member) {
    member("header", self.header);
    member("child_frame_id", self.child_frame_id);
    member("pose", self.pose);
    member("twist", self.twist);
  }
};

struct MapMetaData {
  static constexpr std::string_view kType = "nav_msgs/msg/MapMetaData";
  builtin_interfaces::Time map_load_time;
  float resolution = 0.0F;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  geometry_msgs::Pose origin;
  static void members(auto& self, auto&& member) {
    member("map_load_time", self.map_load_time);
    member("resolution", self.resolution);
    member("width", self.width);
    member("height", self.height);
    member("origin", self.origin);
  }
};

struct OccupancyGrid {
  static constexpr std::string_view kType = "nav_msgs/msg/OccupancyGrid";
  std_msgs::Header header;
  MapMetaData info;
  std::vector<std::int8_t> data;
  static void members(auto& self, auto&& member) {
    member("header", self.header);
    member("info", self.info);
    member("data", self.data);
  }
};

struct Path {
  static constexpr std::string_view kType = "nav_msgs/msg/Path";
  std_msgs::Header header;
  std::vector<geometry_msgs::PoseStamped> poses;
  static void members(auto& self, auto&& member) {
    member("header", self.header);
    member("poses", self.poses);
  }
};

}  // namespace threewe::ros2::nav_msgs
