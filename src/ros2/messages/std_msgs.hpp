// ROS 2 messages of builtin_interfaces and std_msgs.
#pragma once

#include "ros2/messages/description.hpp"

namespace threewe::ros2 {

namespace builtin_interfaces {

struct Time {
  static constexpr std::string_view kType = "builtin_interfaces/msg/Time";
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
  static void members(auto& self, auto&& member) {
    member("sec", self.sec);
    member("nanosec", self.nanosec);
  }
};

}  // namespace builtin_interfaces

namespace std_msgs {

struct Header {
  static constexpr std::string_view kType = "std_msgs/msg/Header";
  builtin_interfaces::Time stamp;
  std::string frame_id;
  static void members(auto& self, auto&& member) {
    member("stamp", self.stamp);
    member("frame_id", self.frame_id);
  }
};

/// What is the same in all of the messages that hold one value.
template <typename T>
struct OneValue {
  T data{};
  static void members(auto& self, auto&& member) { member("data", self.data); }
};

struct Bool : OneValue<bool> {
  static constexpr std::string_view kType = "std_msgs/msg/Bool";
};
struct String : OneValue<std::string> {
  static constexpr std::string_view kType = "std_msgs/msg/String";
};
struct Int32 : OneValue<std::int32_t> {
  static constexpr std::string_view kType = "std_msgs/msg/Int32";
};
struct Float32 : OneValue<float> {
  static constexpr std::string_view kType = "std_msgs/msg/Float32";
};
struct Float64 : OneValue<double> {
  static constexpr std::string_view kType = "std_msgs/msg/Float64";
};

/// A message without members has one on the wire all the same.
struct Empty {
  static constexpr std::string_view kType = "std_msgs/msg/Empty";
  std::uint8_t structure_needs_at_least_one_member = 0;
  static void members(auto& self, auto&& member) {
    member("structure_needs_at_least_one_member", self.structure_needs_at_least_one_member);
  }
};

}  // namespace std_msgs
}  // namespace threewe::ros2
