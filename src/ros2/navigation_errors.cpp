#include "ros2/navigation_errors.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

namespace threewe::ros2 {
namespace {

using Outcome = backend::ExternalNavigator::Outcome;

struct Code {
  std::uint16_t code;
  std::string_view name;
  Outcome outcome;
  std::string_view words;
};

// nav2_msgs/action/*.action
constexpr auto kCodes = std::to_array<Code>({
    {0, "NONE", Outcome::cancelled, "aborted without an error: another goal may have taken its place"},
    {1, "GOAL_REJECTED", Outcome::fault, "one of its servers rejected the goal"},
    {2, "SEND_GOAL_FAILURE", Outcome::fault, "one of its servers was not reached"},
    // FollowPath
    {100, "UNKNOWN", Outcome::fault, "the controller failed"},
    {101, "INVALID_CONTROLLER", Outcome::fault, "there is no such controller"},
    {102, "TF_ERROR", Outcome::lost, "the controller has no transform to where the robot is"},
    {103, "INVALID_PATH", Outcome::no_path, "the controller cannot follow this path"},
    {104, "PATIENCE_EXCEEDED", Outcome::blocked, "the controller has found no way on for too long"},
    {105, "FAILED_TO_MAKE_PROGRESS", Outcome::blocked, "the robot does not get on"},
    {106, "NO_VALID_CONTROL", Outcome::blocked, "no velocity is free of collisions"},
    {107, "CONTROLLER_TIMED_OUT", Outcome::fault, "the controller waited too long for its costmap"},
    {108, "TIMEOUT", Outcome::timeout, "the controller took too long"},
    // ComputePathToPose
    {200, "UNKNOWN", Outcome::fault, "the planner failed"},
    {201, "INVALID_PLANNER", Outcome::fault, "there is no such planner"},
    {202, "TF_ERROR", Outcome::lost, "the planner has no transform to where the robot is"},
    {203, "START_OUTSIDE_MAP", Outcome::no_path, "the robot is outside of the map"},
    {204, "GOAL_OUTSIDE_MAP", Outcome::no_path, "the goal is outside of the map"},
    {205, "START_OCCUPIED", Outcome::blocked, "the robot stands in an obstacle"},
    {206, "GOAL_OCCUPIED", Outcome::no_path, "the goal is in an obstacle"},
    {207, "TIMEOUT", Outcome::no_path, "planning took too long"},
    {208, "NO_VALID_PATH", Outcome::no_path, "there is no path to the goal"},
    // ComputePathThroughPoses
    {300, "UNKNOWN", Outcome::fault, "the planner failed"},
    {301, "INVALID_PLANNER", Outcome::fault, "there is no such planner"},
    {302, "TF_ERROR", Outcome::lost, "the planner has no transform to where the robot is"},
    {303, "START_OUTSIDE_MAP", Outcome::no_path, "the robot is outside of the map"},
    {304, "GOAL_OUTSIDE_MAP", Outcome::no_path, "the goal is outside of the map"},
    {305, "START_OCCUPIED", Outcome::blocked, "the robot stands in an obstacle"},
    {306, "GOAL_OCCUPIED", Outcome::no_path, "the goal is in an obstacle"},
    {307, "TIMEOUT", Outcome::no_path, "planning took too long"},
    {308, "NO_VALID_PATH", Outcome::no_path, "there is no path to the goal"},
    {309, "NO_VIAPOINTS_GIVEN", Outcome::no_path, "there are no poses to plan through"},
    // SmoothPath
    {500, "UNKNOWN", Outcome::fault, "the smoother failed"},
    {501, "INVALID_SMOOTHER", Outcome::fault, "there is no such smoother"},
    {502, "TIMEOUT", Outcome::no_path, "smoothing the path took too long"},
    {503, "SMOOTHED_PATH_IN_COLLISION", Outcome::blocked, "the smoothed path leads through an obstacle"},
    {504, "FAILED_TO_SMOOTH_PATH", Outcome::fault, "the path could not be smoothed"},
    {505, "INVALID_PATH", Outcome::no_path, "the smoother cannot take this path"},
    // FollowWaypoints
    {600, "UNKNOWN", Outcome::fault, "following waypoints failed"},
    {601, "TASK_EXECUTOR_FAILED", Outcome::fault, "the task at a waypoint failed"},
    {602, "NO_VALID_WAYPOINTS", Outcome::no_path, "there are no waypoints"},
    {603, "STOP_ON_MISSED_WAYPOINT", Outcome::blocked, "a waypoint was missed"},
    // Spin, BackUp, DriveOnHeading, Wait
    {700, "UNKNOWN", Outcome::fault, "turning on the spot failed"},
    {701, "TIMEOUT", Outcome::blocked, "turning on the spot took too long"},
    {702, "TF_ERROR", Outcome::lost, "turning on the spot had no transform"},
    {703, "COLLISION_AHEAD", Outcome::blocked, "turning on the spot would collide"},
    {710, "UNKNOWN", Outcome::fault, "backing up failed"},
    {711, "TIMEOUT", Outcome::blocked, "backing up took too long"},
    {712, "TF_ERROR", Outcome::lost, "backing up had no transform"},
    {713, "INVALID_INPUT", Outcome::fault, "backing up was asked for what it cannot do"},
    {714, "COLLISION_AHEAD", Outcome::blocked, "backing up would collide"},
    {720, "UNKNOWN", Outcome::fault, "driving straight failed"},
    {721, "TIMEOUT", Outcome::blocked, "driving straight took too long"},
    {722, "TF_ERROR", Outcome::lost, "driving straight had no transform"},
    {723, "COLLISION_AHEAD", Outcome::blocked, "driving straight would collide"},
    {724, "INVALID_INPUT", Outcome::fault, "driving straight was asked for what it cannot do"},
    {740, "UNKNOWN", Outcome::fault, "waiting failed"},
    {741, "TIMEOUT", Outcome::blocked, "waiting took too long"},
    // NavigateToPose
    {9000, "UNKNOWN", Outcome::fault, "the navigator failed"},
    {9001, "FAILED_TO_LOAD_BEHAVIOR_TREE", Outcome::fault, "its behaviour tree could not be loaded"},
    {9002, "TF_ERROR", Outcome::lost, "the navigator has no transform to where the robot is"},
    {9003, "TIMEOUT", Outcome::timeout, "the navigator took too long"},
});
static_assert(std::ranges::is_sorted(kCodes, {}, &Code::code));

}  // namespace

NavigationError explain(std::uint16_t code, std::string_view message) {
  const auto found = std::ranges::lower_bound(kCodes, code, {}, &Code::code);
  const bool known = found != kCodes.end() && found->code == code;
  NavigationError error{known ? found->outcome : Outcome::fault,
                        known ? fmt::format("{} ({}): {}", found->name, code, found->words)
                              : fmt::format("error code {}, which is not one of Nav2's own", code)};
  if (!message.empty()) error.detail += fmt::format("; \"{}\"", message);
  return error;
}

}  // namespace threewe::ros2
