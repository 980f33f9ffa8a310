// ROS 2 messages by which a system of nodes runs: transforms, clock, diagnostics, and who is in the graph.
#pragma once

#include "ros2/messages/geometry_msgs.hpp"

namespace threewe::ros2 {

namespace tf2_msgs {

struct TFMessage {
  static constexpr std::string_view kType = "tf2_msgs/msg/TFMessage";
  std::vector<geometry_msgs::TransformStamped> transforms;
  static void members(auto& self, auto&& member) { member("transforms", self.transforms); }
};

}  // namespace tf2_msgs

namespace rosgraph_msgs {

struct Clock {
  static constexpr std::string_view kType = "rosgraph_msgs/msg/Clock";
  builtin_interfaces::Time clock;
  static void members(auto& self, auto&& member) { member("clock", self.clock); }
};

}  // namespace rosgraph_msgs

namespace diagnostic_msgs {

struct KeyValue {
  static constexpr std::string_view kType = "diagnostic_msgs/msg/KeyValue";
  std::string key;
  std::string value;
  static void members(auto& self, auto&& member) {
    member("key", self.key);
    member("value", self.value);
  }
};

struct DiagnosticStatus {
  static constexpr std::string_view kType = "diagnostic_msgs/msg/DiagnosticStatus";
  std::byte level{};
  std::string name;
  std::string message;
  std::string hardware_id;
  std::vector<KeyValue> values;
  static void members(auto& self, auto&& member) {
    member("level", self.level);
    member("name", self.name);
    member("message", self.message);
    member("hardware_id", self.hardware_id);
    member("values", self.values);
  }
};

struct DiagnosticArray {
  static constexpr std::string_view kType = "diagnostic_msgs/msg/DiagnosticArray";
  std_msgs::Header header;
  std::vector<DiagnosticStatus> status;
  static void members(auto& self, auto&& member) {
    member("header", self.header);
    member("status", self.status);
  }
};

}  // namespace diagnostic_msgs

namespace rmw_dds_common {

/// The 16 bytes that name an entity of DDS; Humble sends 8 more, which are zero.
struct Gid {
  static constexpr std::string_view kType = "rmw_dds_common/msg/Gid";
  std::array<std::uint8_t, 24> data{};
  static void members(auto& self, auto&& member) {
    if (member.layout == Distribution::humble) {
      member("data", self.data);
    } else {
      member("data", std::span(self.data).template first<16>());
    }
  }
};

struct NodeEntitiesInfo {
  static constexpr std::string_view kType = "rmw_dds_common/msg/NodeEntitiesInfo";
  BoundedString<256> node_namespace;
  BoundedString<256> node_name;
  std::vector<Gid> reader_gid_seq;
  std::vector<Gid> writer_gid_seq;
  static void members(auto& self, auto&& member) {
    member("node_namespace", self.node_namespace);
    member("node_name", self.node_name);
    member("reader_gid_seq", self.reader_gid_seq);
    member("writer_gid_seq", self.writer_gid_seq);
  }
};

struct ParticipantEntitiesInfo {
  static constexpr std::string_view kType = "rmw_dds_common/msg/ParticipantEntitiesInfo";
  Gid gid;
  std::vector<NodeEntitiesInfo> node_entities_info_seq;
  static void members(auto& self, auto&& member) {
    member("gid", self.gid);
    member("node_entities_info_seq", self.node_entities_info_seq);
  }
};

}  // namespace rmw_dds_common

}  // namespace threewe::ros2
