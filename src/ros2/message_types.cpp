#include "ros2/message_types.hpp"

#include <algorithm>
#include <iterator>

#include <fmt/format.h>

#include "core/names.hpp"
#include "ros2/cdr.hpp"
#include "ros2/messages/action_msgs.hpp"
#include "ros2/messages/nav_msgs.hpp"
#include "ros2/messages/sensor_msgs.hpp"
#include "ros2/messages/system_msgs.hpp"
#include "ros2/type_hash.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::ros2 {
namespace {

template <Message T>
constexpr MessageType entry() {
  return {T::kType, type_hash<T>,
          [](std::span<const std::uint8_t> payload,
             Distribution layout) -> tl::expected<std::vector<std::uint8_t>, std::string> {
            return decode<T>(payload, layout).map([layout](const T& message) { return encode(message, layout); });
          }};
}

constexpr auto kTypes = std::to_array<MessageType>({
    entry<action_msgs::CancelGoalRequest>(),
    entry<action_msgs::CancelGoalResponse>(),
    entry<action_msgs::GoalInfo>(),
    entry<action_msgs::GoalStatus>(),
    entry<action_msgs::GoalStatusArray>(),
    entry<builtin_interfaces::Duration>(),
    entry<builtin_interfaces::Time>(),
    entry<diagnostic_msgs::DiagnosticArray>(),
    entry<diagnostic_msgs::DiagnosticStatus>(),
    entry<diagnostic_msgs::KeyValue>(),
    entry<geometry_msgs::Point>(),
    entry<geometry_msgs::Point32>(),
    entry<geometry_msgs::Polygon>(),
    entry<geometry_msgs::PolygonStamped>(),
    entry<geometry_msgs::Pose>(),
    entry<geometry_msgs::PoseArray>(),
    entry<geometry_msgs::PoseStamped>(),
    entry<geometry_msgs::PoseWithCovariance>(),
    entry<geometry_msgs::PoseWithCovarianceStamped>(),
    entry<geometry_msgs::Quaternion>(),
    entry<geometry_msgs::Transform>(),
    entry<geometry_msgs::TransformStamped>(),
    entry<geometry_msgs::Twist>(),
    entry<geometry_msgs::TwistStamped>(),
    entry<geometry_msgs::TwistWithCovariance>(),
    entry<geometry_msgs::Vector3>(),
    entry<nav2_msgs::FollowPath::FeedbackMessage>(),
    entry<nav2_msgs::FollowPath::GetResultRequest>(),
    entry<nav2_msgs::FollowPath::GetResultResponse>(),
    entry<nav2_msgs::FollowPath::SendGoalRequest>(),
    entry<nav2_msgs::FollowPath::SendGoalResponse>(),
    entry<nav2_msgs::FollowWaypoints::FeedbackMessage>(),
    entry<nav2_msgs::FollowWaypoints::GetResultRequest>(),
    entry<nav2_msgs::FollowWaypoints::GetResultResponse>(),
    entry<nav2_msgs::FollowWaypoints::SendGoalRequest>(),
    entry<nav2_msgs::FollowWaypoints::SendGoalResponse>(),
    entry<nav2_msgs::NavigateToPose::FeedbackMessage>(),
    entry<nav2_msgs::NavigateToPose::GetResultRequest>(),
    entry<nav2_msgs::NavigateToPose::GetResultResponse>(),
    entry<nav2_msgs::NavigateToPose::SendGoalRequest>(),
    entry<nav2_msgs::NavigateToPose::SendGoalResponse>(),
    entry<nav_msgs::MapMetaData>(),
    entry<nav_msgs::OccupancyGrid>(),
    entry<nav_msgs::Odometry>(),
    entry<nav_msgs::Path>(),
    entry<rmw_dds_common::Gid>(),
    entry<rmw_dds_common::NodeEntitiesInfo>(),
    entry<rmw_dds_common::ParticipantEntitiesInfo>(),
    entry<rosgraph_msgs::Clock>(),
    entry<sensor_msgs::BatteryState>(),
    entry<sensor_msgs::CameraInfo>(),
    entry<sensor_msgs::CompressedImage>(),
    entry<sensor_msgs::Image>(),
    entry<sensor_msgs::Imu>(),
    entry<sensor_msgs::LaserScan>(),
    entry<sensor_msgs::PointCloud2>(),
    entry<sensor_msgs::PointField>(),
    entry<sensor_msgs::Range>(),
    entry<sensor_msgs::RegionOfInterest>(),
    entry<std_msgs::Bool>(),
    entry<std_msgs::Empty>(),
    entry<std_msgs::Float32>(),
    entry<std_msgs::Float64>(),
    entry<std_msgs::Header>(),
    entry<std_msgs::Int32>(),
    entry<std_msgs::String>(),
    entry<tf2_msgs::TFMessage>(),
    entry<unique_identifier_msgs::UUID>(),
});

constexpr std::string_view kInfix = "::dds_::";

std::string replaced(std::string_view text, std::string_view from, std::string_view to) {
  std::string result;
  for (std::size_t at = text.find(from); at != std::string_view::npos; at = text.find(from)) {
    result.append(text.substr(0, at)).append(to);
    text.remove_prefix(at + from.size());
  }
  return result.append(text);
}

}  // namespace

std::string_view to_string(Distribution distribution) {
  switch (distribution) {
    case Distribution::humble: return "humble";
    case Distribution::jazzy: return "jazzy";
    case Distribution::kilted: return "kilted";
  }
  return "";
}

std::span<const MessageType> message_types() { return kTypes; }

const MessageType& message_type(std::string_view name) {
  const auto found = std::ranges::find(kTypes, name, &MessageType::name);
  if (found != kTypes.end()) return *found;
  std::vector<std::string> names;
  for (const MessageType& type : kTypes) names.emplace_back(type.name);
  throw ConfigError(unknown_name("message", name, names));
}

std::string dds_type_name(std::string_view type) {
  const std::size_t last = type.rfind('/');
  return fmt::format("{}{}{}_", replaced(type.substr(0, last), "/", "::"), kInfix, type.substr(last + 1));
}

std::string ros_type_name(std::string_view dds_type) {
  const std::size_t infix = dds_type.find(kInfix);
  if (infix == std::string_view::npos || !dds_type.ends_with('_')) return "";
  const std::string_view last = dds_type.substr(infix + kInfix.size());
  return fmt::format("{}/{}", replaced(dds_type.substr(0, infix), "::", "/"), last.substr(0, last.size() - 1));
}

std::vector<Distribution> distributions_with(std::string_view type, std::string_view hash) {
  std::vector<Distribution> distributions;
  const auto found = std::ranges::find(kTypes, type, &MessageType::name);
  if (found == kTypes.end()) return distributions;
  std::ranges::copy_if(kDistributions, std::back_inserter(distributions),
                       [&](Distribution layout) { return found->hash(layout) == hash; });
  return distributions;
}

}  // namespace threewe::ros2
