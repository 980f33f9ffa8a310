// ROS 2 messages of geometry_msgs.
#pragma once

#include "ros2/messages/std_msgs.hpp"

namespace threewe::ros2::geometry_msgs {

struct Vector3 {
  static constexpr std::string_view kType = "geometry_msgs/msg/Vector3";
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
  static void members(auto& self, auto&& member) {
    member("x", self.x);
    member("y", self.y);
    member("z", self.z);
  }
};

struct Point {
  static constexpr std::string_view kType = "geometry_msgs/msg/Point";
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
  static void members(auto& self, auto&& member) {
    member("x", self.x);
    member("y", self.y);
    member("z", self.z);
  }
};

struct Quaternion {
  static constexpr std::string_view kType = "geometry_msgs/msg/Quaternion";
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
  double w = 1.0;
  static void members(auto& self, auto&& member) {
    member("x", self.x);
    member("y", self.y);
    member("z", self.z);
    member("w", self.w);
  }
};

struct Pose {
  static constexpr std::string_view kType = "geometry_msgs/msg/Pose";
  Point position;
  Quaternion orientation;
  static void members(auto& self, auto&& member) {
    member("position", self.position);
    member("orientation", self.orientation);
  }
};

struct PoseStamped {
  static constexpr std::string_view kType = "geometry_msgs/msg/PoseStamped";
  std_msgs::Header header;
  Pose pose;
  static void members(auto& self, auto&& member) {
    member("header", self.header);
    member("pose", self.pose);
  }
};

struct PoseWithCovariance {
  static constexpr std::string_view kType = "geometry_msgs/msg/PoseWithCovariance";
  Pose pose;
  std::array<double, 36> covariance{};
  static void members(auto& self, auto&& member) {
    member("pose", self.pose);
    member("covariance", self.covariance);
  }
};

struct PoseWithCovarianceStamped {
  static constexpr std::string_view kType = "geometry_msgs/msg/PoseWithCovarianceStamped";
  std_msgs::Header header;
  PoseWithCovariance pose;
  static void members(auto& self, auto&& member) {
    member("header", self.header);
    member("pose", self.pose);
  }
};

struct PoseArray {
  static constexpr std::string_view kType = "geometry_msgs/msg/PoseArray";
  std_msgs::Header header;
  std::vector<Pose> poses;
  static void members(auto& self, auto&& member) {
    member("header", self.header);
    member("poses", self.poses);
  }
};

struct Twist {
  static constexpr std::string_view kType = "geometry_msgs/msg/Twist";
  Vector3 linear;
  Vector3 angular;
  static void members(auto& self, auto&& member) {
    member("linear", self.linear);
    member("angular", self.angular);
  }
};

struct TwistStamped {
  static constexpr std::string_view kType = "geometry_msgs/msg/TwistStamped";
  std_msgs::Header header;
  Twist twist;
  static void members(auto& self, auto&& member) {
    member("header", self.header);
    member("twist", self.twist);
  }
};

struct TwistWithCovariance {
  static constexpr std::string_view kType = "geometry_msgs/msg/TwistWithCovariance";
  Twist twist;
  std::array<double, 36> covariance{};
  static void members(auto& self, auto&& member) {
    member("twist", self.twist);
    member("covariance", self.covariance);
  }
};

struct Transform {
  static constexpr std::string_view kType = "geometry_msgs/msg/Transform";
  Vector3 translation;
  Quaternion rotation;
  static void members(auto& self, auto&& member) {
    member("translation", self.translation);
    member("rotation", self.rotation);
  }
};

struct TransformStamped {
  static constexpr std::string_view kType = "geometry_msgs/msg/TransformStamped";
  std_msgs::Header header;
  std::string child_frame_id;
  Transform transform;
  static void members(auto& self, auto&& member) {
    member("header", self.header);
    member("child_frame_id", self.child_frame_id);
    member("transform", self.transform);
  }
};

struct Point32 {
  static constexpr std::string_view kType = "geometry_msgs/msg/Point32";
  float x = 0.0F;
  float y = 0.0F;
  float z = 0.0F;
  static void members(auto& self, auto&& member) {
    member("x", self.x);
    member("y", self.y);
    member("z", self.z);
  }
};

struct Polygon {
  static constexpr std::string_view kType = "geometry_msgs/msg/Polygon";
  std::vector<Point32> points;
  static void members(auto& self, auto&& member) { member("points", self.points); }
};

struct PolygonStamped {
  static constexpr std::string_view kType = "geometry_msgs/msg/PolygonStamped";
  std_msgs::Header header;
  Polygon polygon;
  static void members(auto& self, auto&& member) {
    member("header", self.header);
    member("polygon", self.polygon);
  }
};

}  // namespace threewe::ros2::geometry_msgs
