// ROS 2 messages of actions, and of the three of Nav2's that drive a robot.
#pragma once

#include "ros2/messages/nav_msgs.hpp"

namespace threewe::ros2 {

namespace builtin_interfaces {

struct Duration {
  static constexpr std::string_view kType = "builtin_interfaces/msg/Duration";
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
  static void members(auto& self, auto&& member) {
    member("sec", self.sec);
    member("nanosec", self.nanosec);
  }
};

}  // namespace builtin_interfaces

namespace unique_identifier_msgs {

struct UUID {
  static constexpr std::string_view kType = "unique_identifier_msgs/msg/UUID";
  std::array<std::uint8_t, 16> uuid{};
  static void members(auto& self, auto&& member) { member("uuid", self.uuid); }
  friend bool operator==(const UUID&, const UUID&) = default;
};

}  // namespace unique_identifier_msgs

namespace action_msgs {

struct GoalInfo {
  static constexpr std::string_view kType = "action_msgs/msg/GoalInfo";
  unique_identifier_msgs::UUID goal_id;
  builtin_interfaces::Time stamp;
  static void members(auto& self, auto&& member) {
    member("goal_id", self.goal_id);
    member("stamp", self.stamp);
  }
};

struct GoalStatus {
  static constexpr std::string_view kType = "action_msgs/msg/GoalStatus";
  static constexpr std::int8_t kSucceeded = 4;
  static constexpr std::int8_t kCanceled = 5;
  static constexpr std::int8_t kAborted = 6;
  GoalInfo goal_info;
  std::int8_t status = 0;
  static void members(auto& self, auto&& member) {
    member("goal_info", self.goal_info);
    member("status", self.status);
  }
};

struct GoalStatusArray {
  static constexpr std::string_view kType = "action_msgs/msg/GoalStatusArray";
  std::vector<GoalStatus> status_list;
  static void members(auto& self, auto&& member) { member("status_list", self.status_list); }
};

struct CancelGoalRequest {
  static constexpr std::string_view kType = "action_msgs/srv/CancelGoal_Request";
  GoalInfo goal_info;
  static void members(auto& self, auto&& member) { member("goal_info", self.goal_info); }
};

struct CancelGoalResponse {
  static constexpr std::string_view kType = "action_msgs/srv/CancelGoal_Response";
  std::int8_t return_code = 0;
  std::vector<GoalInfo> goals_canceling;
  static void members(auto& self, auto&& member) {
    member("return_code", self.return_code);
    member("goals_canceling", self.goals_canceling);
  }
};

}  // namespace action_msgs

namespace nav2_msgs {

using unique_identifier_msgs::UUID;

struct NavigateToPoseGoal {
  static constexpr std::string_view kType = "nav2_msgs/action/NavigateToPose_Goal";
  geometry_msgs::PoseStamped pose;
  std::string behavior_tree;
  static void members(auto& self, auto&& member) {
    member("pose", self.pose);
    member("behavior_tree", self.behavior_tree);
  }
};

/// In Humble no error is stated.
struct NavigateToPoseResult {
  static constexpr std::string_view kType = "nav2_msgs/action/NavigateToPose_Result";
  std_msgs::Empty result;
  std::uint16_t error_code = 0;
  std::string error_msg;
  static void members(auto& self, auto&& member) {
    if (member.layout == Distribution::humble) return member("result", self.result);
    member("error_code", self.error_code);
    member("error_msg", self.error_msg);
  }
};

struct NavigateToPoseFeedback {
  static constexpr std::string_view kType = "nav2_msgs/action/NavigateToPose_Feedback";
  geometry_msgs::PoseStamped current_pose;
  builtin_interfaces::Duration navigation_time;
  builtin_interfaces::Duration estimated_time_remaining;
  std::int16_t number_of_recoveries = 0;
  float distance_remaining = 0.0F;
  static void members(auto& self, auto&& member) {
    member("current_pose", self.current_pose);
    member("navigation_time", self.navigation_time);
    member("estimated_time_remaining", self.estimated_time_remaining);
    member("number_of_recoveries", self.number_of_recoveries);
    member("distance_remaining", self.distance_remaining);
  }
};

/// `progress_checker_id` came with Iron.
struct FollowPathGoal {
  static constexpr std::string_view kType = "nav2_msgs/action/FollowPath_Goal";
  nav_msgs::Path path;
  std::string controller_id;
  std::string goal_checker_id;
  std::string progress_checker_id;
  static void members(auto& self, auto&& member) {
    member("path", self.path);
    member("controller_id", self.controller_id);
    member("goal_checker_id", self.goal_checker_id);
    if (member.layout != Distribution::humble) member("progress_checker_id", self.progress_checker_id);
  }
};

/// In Humble no error is stated.
struct FollowPathResult {
  static constexpr std::string_view kType = "nav2_msgs/action/FollowPath_Result";
  std_msgs::Empty result;
  std::uint16_t error_code = 0;
  std::string error_msg;
  static void members(auto& self, auto&& member) {
    member("result", self.result);
    if (member.layout == Distribution::humble) return;
    member("error_code", self.error_code);
    member("error_msg", self.error_msg);
  }
};

struct FollowPathFeedback {
  static constexpr std::string_view kType = "nav2_msgs/action/FollowPath_Feedback";
  float distance_to_goal = 0.0F;
  float speed = 0.0F;
  static void members(auto& self, auto&& member) {
    member("distance_to_goal", self.distance_to_goal);
    member("speed", self.speed);
  }
};

/// Loops came with Iron.
struct FollowWaypointsGoal {
  static constexpr std::string_view kType = "nav2_msgs/action/FollowWaypoints_Goal";
  std::uint32_t number_of_loops = 0;
  std::uint32_t goal_index = 0;
  std::vector<geometry_msgs::PoseStamped> poses;
  static void members(auto& self, auto&& member) {
    if (member.layout != Distribution::humble) {
      member("number_of_loops", self.number_of_loops);
      member("goal_index", self.goal_index);
    }
    member("poses", self.poses);
  }
};

/// A waypoint that was missed, in Jazzy.
struct MissedWaypoint {
  static constexpr std::string_view kType = "nav2_msgs/msg/MissedWaypoint";
  std::uint32_t index = 0;
  geometry_msgs::PoseStamped goal;
  std::uint16_t error_code = 0;
  static void members(auto& self, auto&& member) {
    member("index", self.index);
    member("goal", self.goal);
    member("error_code", self.error_code);
  }
};

/// The same from Kilted on.
struct WaypointStatus {
  static constexpr std::string_view kType = "nav2_msgs/msg/WaypointStatus";
  std::uint8_t waypoint_status = 0;
  std::uint32_t waypoint_index = 0;
  geometry_msgs::PoseStamped waypoint_pose;
  std::uint16_t error_code = 0;
  std::string error_msg;
  static void members(auto& self, auto&& member) {
    member("waypoint_status", self.waypoint_status);
    member("waypoint_index", self.waypoint_index);
    member("waypoint_pose", self.waypoint_pose);
    member("error_code", self.error_code);
    member("error_msg", self.error_msg);
  }
};

/// Each distribution has another list of what was missed; in Humble without errors.
struct FollowWaypointsResult {
  static constexpr std::string_view kType = "nav2_msgs/action/FollowWaypoints_Result";
  std::vector<std::int32_t> missed_indices;
  std::vector<MissedWaypoint> missed_waypoints;
  std::vector<WaypointStatus> waypoint_statuses;
  std::uint16_t error_code = 0;
  std::string error_msg;
  static void members(auto& self, auto&& member) {
    constexpr std::string_view kMissed = "missed_waypoints";
    if (member.layout == Distribution::humble) return member(kMissed, self.missed_indices);
    if (member.layout == Distribution::jazzy) member(kMissed, self.missed_waypoints);
    if (member.layout == Distribution::kilted) member(kMissed, self.waypoint_statuses);
    member("error_code", self.error_code);
    member("error_msg", self.error_msg);
  }
};

struct FollowWaypointsFeedback {
  static constexpr std::string_view kType = "nav2_msgs/action/FollowWaypoints_Feedback";
  std::uint32_t current_waypoint = 0;
  static void members(auto& self, auto&& member) { member("current_waypoint", self.current_waypoint); }
};

/// The messages by which a client and a server of an action talk of a goal, its result and its feedback.
template <Message Goal>
struct SendGoalRequest {
  UUID goal_id;
  Goal goal;
  static void members(auto& self, auto&& member) {
    member("goal_id", self.goal_id);
    member("goal", self.goal);
  }
};
struct SendGoalResponse {
  bool accepted = false;
  builtin_interfaces::Time stamp;
  static void members(auto& self, auto&& member) {
    member("accepted", self.accepted);
    member("stamp", self.stamp);
  }
};
struct GetResultRequest {
  UUID goal_id;
  static void members(auto& self, auto&& member) { member("goal_id", self.goal_id); }
};
template <Message Result>
struct GetResultResponse {
  std::int8_t status = 0;
  Result result;
  static void members(auto& self, auto&& member) {
    member("status", self.status);
    member("result", self.result);
  }
};
template <Message Feedback>
struct FeedbackMessage {
  UUID goal_id;
  Feedback feedback;
  static void members(auto& self, auto&& member) {
    member("goal_id", self.goal_id);
    member("feedback", self.feedback);
  }
};

/// Drives to a pose, by a planner, a controller and recoveries.
struct NavigateToPose {
  static constexpr std::string_view kName = "navigate_to_pose";
  struct SendGoalRequest : nav2_msgs::SendGoalRequest<NavigateToPoseGoal> {
    static constexpr std::string_view kType = "nav2_msgs/action/NavigateToPose_SendGoal_Request";
  };
  struct SendGoalResponse : nav2_msgs::SendGoalResponse {
    static constexpr std::string_view kType = "nav2_msgs/action/NavigateToPose_SendGoal_Response";
  };
  struct GetResultRequest : nav2_msgs::GetResultRequest {
    static constexpr std::string_view kType = "nav2_msgs/action/NavigateToPose_GetResult_Request";
  };
  struct GetResultResponse : nav2_msgs::GetResultResponse<NavigateToPoseResult> {
    static constexpr std::string_view kType = "nav2_msgs/action/NavigateToPose_GetResult_Response";
  };
  struct FeedbackMessage : nav2_msgs::FeedbackMessage<NavigateToPoseFeedback> {
    static constexpr std::string_view kType = "nav2_msgs/action/NavigateToPose_FeedbackMessage";
  };
};

/// Drives along a path, by a controller alone.
struct FollowPath {
  static constexpr std::string_view kName = "follow_path";
  struct SendGoalRequest : nav2_msgs::SendGoalRequest<FollowPathGoal> {
    static constexpr std::string_view kType = "nav2_msgs/action/FollowPath_SendGoal_Request";
  };
  struct SendGoalResponse : nav2_msgs::SendGoalResponse {
    static constexpr std::string_view kType = "nav2_msgs/action/FollowPath_SendGoal_Response";
  };
  struct GetResultRequest : nav2_msgs::GetResultRequest {
    static constexpr std::string_view kType = "nav2_msgs/action/FollowPath_GetResult_Request";
  };
  struct GetResultResponse : nav2_msgs::GetResultResponse<FollowPathResult> {
    static constexpr std::string_view kType = "nav2_msgs/action/FollowPath_GetResult_Response";
  };
  struct FeedbackMessage : nav2_msgs::FeedbackMessage<FollowPathFeedback> {
    static constexpr std::string_view kType = "nav2_msgs/action/FollowPath_FeedbackMessage";
  };
};

/// Drives to poses one after the other, each by NavigateToPose.
struct FollowWaypoints {
  static constexpr std::string_view kName = "follow_waypoints";
  struct SendGoalRequest : nav2_msgs::SendGoalRequest<FollowWaypointsGoal> {
    static constexpr std::string_view kType = "nav2_msgs/action/FollowWaypoints_SendGoal_Request";
  };
  struct SendGoalResponse : nav2_msgs::SendGoalResponse {
    static constexpr std::string_view kType = "nav2_msgs/action/FollowWaypoints_SendGoal_Response";
  };
  struct GetResultRequest : nav2_msgs::GetResultRequest {
    static constexpr std::string_view kType = "nav2_msgs/action/FollowWaypoints_GetResult_Request";
  };
  struct GetResultResponse : nav2_msgs::GetResultResponse<FollowWaypointsResult> {
    static constexpr std::string_view kType = "nav2_msgs/action/FollowWaypoints_GetResult_Response";
  };
  struct FeedbackMessage : nav2_msgs::FeedbackMessage<FollowWaypointsFeedback> {
    static constexpr std::string_view kType = "nav2_msgs/action/FollowWaypoints_FeedbackMessage";
  };
};

}  // namespace nav2_msgs
}  // namespace threewe::ros2
