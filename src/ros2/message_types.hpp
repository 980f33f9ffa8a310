// Table of message types: all messages that we know, by name.
#pragma once

#include <tl/expected.hpp>

#include "ros2/messages/description.hpp"

namespace threewe::ros2 {

/// One message, where its type is known at run time alone.
struct MessageType {
  std::string_view name;  ///< such as "geometry_msgs/msg/Twist"
  /// "RIHS01_..." of its layout in a distribution.
  std::string (*hash)(Distribution layout);
  /// Reads a payload and writes the same message again, or says what is wrong with it.
  tl::expected<std::vector<std::uint8_t>, std::string> (*recode)(std::span<const std::uint8_t>, Distribution layout);
};

/// All of them, by name.
std::span<const MessageType> message_types();
/// Throws ConfigError naming the nearest right one.
const MessageType& message_type(std::string_view name);

/// "geometry_msgs/msg/Twist" as DDS has it: "geometry_msgs::msg::dds_::Twist_".
std::string dds_type_name(std::string_view type);
/// The other way round; empty for a type that is no ROS 2 message.
std::string ros_type_name(std::string_view dds_type);
/// The distributions in which a type has this hash; none for a type or a hash that we do not know.
std::vector<Distribution> distributions_with(std::string_view type, std::string_view hash);

}  // namespace threewe::ros2
