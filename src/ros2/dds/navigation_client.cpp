#include "ros2/dds/navigation_client.hpp"

#include <algorithm>
#include <cstring>
#include <type_traits>
#include <utility>

#include <fmt/format.h>

#include "ros2/message_types.hpp"
#include "ros2/navigation_errors.hpp"
#include "ros2/publications.hpp"

namespace threewe::ros2 {
namespace {

using namespace std::chrono_literals;
using action_msgs::GoalStatus;
using Way = backend::ExternalNavigator::Way;

constexpr auto kAnswer = 3s;       // for whether a goal is taken
constexpr auto kSilence = 2s;      // from feedback to feedback, which comes several times a second
constexpr auto kResult = 1s;       // for a result, once its goal has ended
constexpr auto kCancelled = 3s;    // for a goal that is to be cancelled to end
constexpr auto kAgain = 1s;        // from one request to cancel a goal to the next
constexpr double kSpacing = 0.05;  // [m] of a path's poses, which controllers want closer than their costmap's cells
constexpr Qos kStatus{.reliable = true, .transient_local = true, .depth = 1};

// The layout of a service's replies, by the hash that its server states; empty for one that we do not know.
std::optional<Distribution> layout_of(Node& node, const Node::Client& client, std::string_view reply_type) {
  for (const Endpoint& endpoint : node.endpoints()) {
    if (endpoint.topic != "rr" + client.service + "Reply" || !endpoint.publishes) continue;
    if (endpoint.hash.empty()) return Distribution::humble;
    const auto known = distributions_with(reply_type, endpoint.hash);
    return known.empty() ? std::nullopt : std::optional(known.back());
  }
  return std::nullopt;
}

geometry_msgs::PoseStamped to_stamped(const Pose2D& pose, const std::string& frame) {
  geometry_msgs::PoseStamped stamped;
  stamped.header.frame_id = frame;  // without a stamp: the newest transforms count
  stamped.pose.position = {pose.x, pose.y, 0.0};
  stamped.pose.orientation = to_quaternion(pose.theta);
  return stamped;
}

// Along the straight lines between poses, each heading for the next.
std::vector<geometry_msgs::PoseStamped> densified(const std::vector<Pose2D>& path, const std::string& frame) {
  std::vector<geometry_msgs::PoseStamped> dense;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    const Vec2 step = path[i + 1].position() - path[i].position();
    const int count = std::max(1, static_cast<int>(norm(step) / kSpacing));
    for (int k = 0; k < count; ++k) {
      const Vec2 at = path[i].position() + (static_cast<double>(k) / count) * step;
      dense.push_back(to_stamped({at.x, at.y, path[i].theta}, frame));
    }
  }
  dense.push_back(to_stamped(path.back(), frame));
  return dense;
}

Payload request_of(const backend::ExternalNavigator::Goal& goal, const unique_identifier_msgs::UUID& id,
                   const std::string& frame, Distribution layout) {
  if (goal.way == Way::along_path) {
    nav2_msgs::FollowPath::SendGoalRequest request;
    request.goal_id = id;
    request.goal.path.header.frame_id = frame;
    request.goal.path.poses = densified(goal.path, frame);
    return encode(request, layout);
  }
  if (goal.way == Way::to_waypoints) {
    nav2_msgs::FollowWaypoints::SendGoalRequest request;
    request.goal_id = id;
    for (const Pose2D& pose : goal.path) request.goal.poses.push_back(to_stamped(pose, frame));
    return encode(request, layout);
  }
  nav2_msgs::NavigateToPose::SendGoalRequest request;
  request.goal_id = id;
  request.goal.pose = to_stamped(goal.path.back(), frame);
  return encode(request, layout);
}

// A waypoint that was missed, whatever the distribution says of it.
struct Missed {
  std::size_t index = 0;
  std::uint16_t code = 0;
  std::string message;
};

std::vector<Missed> missed_of(const nav2_msgs::FollowWaypointsResult& result) {
  std::vector<Missed> missed;
  for (const std::int32_t index : result.missed_indices) missed.push_back({static_cast<std::size_t>(index), 0, ""});
  for (const auto& one : result.missed_waypoints) missed.push_back({one.index, one.error_code, ""});
  for (const auto& one : result.waypoint_statuses)
    missed.push_back({one.waypoint_index, one.error_code, one.error_msg});
  return missed;
}

}  // namespace

NavigationClient::NavigationClient(const LinkSpec& link) : name_space_(link.name_space), map_frame_(link.map_frame) {}

// Connecting.

void NavigationClient::connect(Node& node) {
  {
    const std::scoped_lock lock(mutex_);
    current_.reset();
    endings_.clear();
    report_ = {};
    trouble_.clear();
  }
  connect<nav2_msgs::NavigateToPose>(node);
  connect<nav2_msgs::FollowPath>(node);
  connect<nav2_msgs::FollowWaypoints>(node);
  (void)node.subscribe(name_space_ + "/plan", nav_msgs::Path::kType, {.depth = 1},
                       [this](std::span<const std::uint8_t> payload, std::uint64_t) { receive_plan(payload); });
}

template <typename A>
NavigationClient::Action& NavigationClient::action_of() {
  if constexpr (std::is_same_v<A, nav2_msgs::NavigateToPose>) return to_pose_;
  if constexpr (std::is_same_v<A, nav2_msgs::FollowPath>) return along_path_;
  if constexpr (std::is_same_v<A, nav2_msgs::FollowWaypoints>) return to_waypoints_;
}

template <typename A>
void NavigationClient::connect(Node& node) {
  Action& action = action_of<A>();
  action.name = fmt::format("{}/{}", name_space_, A::kName);
  const std::string prefix = action.name + "/_action/";
  action.reply_type = A::GetResultResponse::kType;
  action.send = node.add_client(
      prefix + "send_goal", A::SendGoalRequest::kType, A::SendGoalResponse::kType,
      [this](std::span<const std::uint8_t> payload, auto request) { receive_acceptance<A>(payload, request); });
  action.result = node.add_client(
      prefix + "get_result", A::GetResultRequest::kType, A::GetResultResponse::kType,
      [this](std::span<const std::uint8_t> payload, auto request) { receive_result<A>(payload, request); });
  action.cancel = node.add_client(prefix + "cancel_goal", action_msgs::CancelGoalRequest::kType,
                                  action_msgs::CancelGoalResponse::kType,
                                  [this, &action](std::span<const std::uint8_t> payload, auto request) {
                                    receive_cancelled(action, payload, request);
                                  });
  action.feedback =
      node.subscribe(prefix + "feedback", A::FeedbackMessage::kType, {.depth = 10},
                     [this](std::span<const std::uint8_t> payload, auto) { receive_feedback<A>(payload); });
  action.status = node.subscribe(prefix + "status", action_msgs::GoalStatusArray::kType, kStatus,
                                 [this](std::span<const std::uint8_t> payload, auto) { receive_status(payload); });
}

std::string NavigationClient::missing(Node& node) {
  const auto absent = [&](const Action& action) {
    return !node.has_server(action.send) || !node.has_server(action.result) || !node.has_server(action.cancel) ||
           node.peers(action.feedback) == 0 || node.peers(action.status) == 0;
  };
  if (absent(to_pose_)) {
    return fmt::format("navigation 'nav2': no node serves the action {}: is Nav2 running and active?", to_pose_.name);
  }
  if (!layout_of(node, to_pose_.result, nav2_msgs::NavigateToPose::GetResultResponse::kType)) {
    return fmt::format("navigation 'nav2': the action {} has a type hash that is not known: known are Humble to Kilted",
                       to_pose_.name);
  }
  return "";
}

// In the runtime's thread.

void NavigationClient::start(const Goal& goal) {
  const std::scoped_lock lock(mutex_);
  end_at_server();
  current_.emplace();
  current_->goal = goal;
  current_->heard = Clock::now();
  report_ = {};
}

void NavigationClient::cancel() {
  const std::scoped_lock lock(mutex_);
  end_at_server();
  current_.reset();
}

/// What its server has been sent of the goal in progress, it is to end. Needs the lock.
void NavigationClient::end_at_server() {
  if (!current_ || current_->action == nullptr || current_->final_status) return;
  Ending& ending = endings_.emplace_back();
  ending.id = current_->id;
  ending.action = current_->action;
  ending.since = Clock::now();
}

bool NavigationClient::drives() const {
  const std::scoped_lock lock(mutex_);
  return current_.has_value();
}

backend::ExternalNavigator::Report NavigationClient::report() const {
  const std::scoped_lock lock(mutex_);
  return report_;
}

std::string NavigationClient::trouble() const {
  const std::scoped_lock lock(mutex_);
  return trouble_;
}

// In the node's thread.

void NavigationClient::step(Node& node) {
  send_cancel(node);
  send_goal(node);
  ask_for_result(node);
  watch(node);
}

void NavigationClient::send_cancel(Node& node) {
  const std::scoped_lock lock(mutex_);
  for (Ending& ending : endings_) {
    if (Clock::now() - ending.sent < kAgain) continue;
    action_msgs::CancelGoalRequest request;
    request.goal_info.goal_id = ending.id;
    ending.sent = Clock::now();
    ending.number = node.call(ending.action->cancel, encode(request, kAnyLayout));
  }
}

void NavigationClient::send_goal(Node& node) {
  std::optional<Current> next;
  {
    const std::scoped_lock lock(mutex_);
    if (!current_ || current_->action != nullptr) return;
    next = current_;
  }
  const Way way = next->goal.way;
  const Action& action = way == Way::to_pose ? to_pose_ : way == Way::along_path ? along_path_ : to_waypoints_;
  const auto layout = layout_of(node, action.result, action.reply_type);
  if (!layout || !node.has_server(action.send) || !node.has_server(action.result)) {
    const std::scoped_lock lock(mutex_);
    return finish(Outcome::fault,
                  layout ? fmt::format("no node serves the action {}", action.name)
                         : fmt::format("no node serves the action {} with types that are known", action.name));
  }
  for (std::size_t i = 0; i < 16; i += 8) {
    const std::uint64_t bits = random_();
    std::memcpy(next->id.uuid.data() + i, &bits, sizeof bits);
  }
  next->id.uuid[6] = static_cast<std::uint8_t>((next->id.uuid[6] & 0x0fU) | 0x40U);  // version 4, by chance
  next->id.uuid[8] = static_cast<std::uint8_t>((next->id.uuid[8] & 0x3fU) | 0x80U);

  // its number is known before the answer can come
  const std::scoped_lock lock(mutex_);
  if (!current_ || current_->action != nullptr) return;
  current_->id = next->id;
  current_->action = &action;
  current_->layout = *layout;
  current_->heard = Clock::now();
  current_->send_number = node.call(action.send, request_of(next->goal, next->id, map_frame_, *layout));
}

void NavigationClient::ask_for_result(Node& node) {
  const std::scoped_lock lock(mutex_);
  if (!current_ || !current_->accepted || current_->result_number != 0) return;
  nav2_msgs::GetResultRequest request;
  request.goal_id = current_->id;
  CdrWriter writer(current_->layout);  // of either action: they are alike
  nav2_msgs::GetResultRequest::members(request, writer);
  current_->result_number = node.call(current_->action->result, writer.take());
}

/// What has not come within its time.
void NavigationClient::watch(Node& node) {
  const std::scoped_lock lock(mutex_);
  const auto now = Clock::now();
  std::erase_if(endings_, [&](const Ending& ending) { return node.peers(ending.action->status) == 0; });  // it is gone
  for (const Ending& ending : endings_) {
    if (now - ending.since > kCancelled) {
      trouble_ =
          fmt::format("{} has not ended a goal that was cancelled: the robot may still be driven", ending.action->name);
    }
  }
  if (endings_.empty()) trouble_.clear();
  if (!current_ || current_->action == nullptr) return;
  const auto since = now - current_->heard;
  const std::string& name = current_->action->name;
  if (current_->final_status) {
    if (since > kResult) {
      const bool succeeded = *current_->final_status == GoalStatus::kSucceeded;
      const bool cancelled = *current_->final_status == GoalStatus::kCanceled;
      finish(succeeded   ? Outcome::reached
             : cancelled ? Outcome::cancelled
                         : Outcome::fault,
             fmt::format("{} has ended the goal without stating a result", name));
    }
  } else if (!current_->accepted && since > kAnswer) {
    end_at_server();
    finish(Outcome::fault, fmt::format("{} has not answered for 3 s", name));
  } else if (current_->accepted && since > kSilence) {
    end_at_server();
    finish(Outcome::fault,
           fmt::format("{} has sent no feedback for 2 s: Nav2 has died, is out of reach or lacks a transform", name));
  }
}

void NavigationClient::release(Node& node) {
  constexpr Duration kPatience = 200ms;
  cancel();
  send_cancel(node);
  for (const Action* action : {&to_pose_, &along_path_, &to_waypoints_}) {
    node.wait_until_received(action->cancel.requests, kPatience);
  }
}

/// Needs the lock.
void NavigationClient::finish(Outcome outcome, const std::string& detail) {
  report_.outcome = outcome;
  report_.detail = outcome == Outcome::reached ? "" : "Nav2: " + detail;
  current_.reset();
}

// In threads of Cyclone's.

template <typename A>
void NavigationClient::receive_acceptance(std::span<const std::uint8_t> payload, std::int64_t request) {
  const auto response = decode<typename A::SendGoalResponse>(payload, kAnyLayout);
  const std::scoped_lock lock(mutex_);
  const bool ours = current_ && current_->action == &action_of<A>() && current_->send_number == request;
  if (!ours || !response) return;
  current_->heard = Clock::now();
  current_->accepted = response->accepted;
  if (!response->accepted) finish(Outcome::fault, fmt::format("{} has rejected the goal", current_->action->name));
}

template <typename A>
void NavigationClient::receive_result(std::span<const std::uint8_t> payload, std::int64_t request) {
  const std::scoped_lock lock(mutex_);
  const bool ours = current_ && current_->action == &action_of<A>() && current_->result_number != 0 &&
                    current_->result_number == request;
  if (!ours) return;
  const auto response = decode<typename A::GetResultResponse>(payload, current_->layout);
  if (!response) return finish(Outcome::fault, "a result that cannot be read: " + response.error());
  const bool succeeded = response->status == GoalStatus::kSucceeded;
  if constexpr (std::is_same_v<A, nav2_msgs::FollowWaypoints>) {
    const bool says = succeeded || response->status == GoalStatus::kAborted;
    if (says && !missed_of(response->result).empty()) return finish_by(response->result, succeeded);
  }
  if (succeeded) return finish(Outcome::reached, "");
  if (response->status == GoalStatus::kCanceled) {
    return finish(Outcome::cancelled, "the goal was cancelled by another program");
  }
  if (response->status != GoalStatus::kAborted) {
    return finish(Outcome::fault, fmt::format("{} does not know the goal", current_->action->name));
  }
  if (current_->layout == Distribution::humble) {
    return finish(Outcome::blocked, "aborted; in Humble it does not state why");
  }
  const NavigationError error = explain(response->result.error_code, response->result.error_msg);
  finish(error.outcome, error.detail);
}

/// Where waypoints were missed: why the first one was. Needs the lock.
void NavigationClient::finish_by(const nav2_msgs::FollowWaypointsResult& result, bool succeeded) {
  const std::vector<Missed> missed = missed_of(result);
  const std::size_t count = current_->goal.path.size();
  std::string which = fmt::format("waypoint {} of {} was missed", missed.front().index + 1, count);
  if (missed.size() > 1)
    which =
        fmt::format("{} of {} waypoints were missed, the first is {}", missed.size(), count, missed.front().index + 1);
  if (!succeeded) which += ", where it stopped";
  if (current_->layout == Distribution::humble)
    return finish(Outcome::blocked, which + "; in Humble it does not state why");
  NavigationError error = explain(missed.front().code, missed.front().message);
  finish(error.outcome, fmt::format("{}: {}", which, error.detail));
}

template <typename A>
void NavigationClient::receive_feedback(std::span<const std::uint8_t> payload) {
  const auto message = decode<typename A::FeedbackMessage>(payload, kAnyLayout);
  if (!message) return;
  const std::scoped_lock lock(mutex_);
  if (!is_current(message->goal_id)) return;
  current_->heard = Clock::now();
  if constexpr (std::is_same_v<A, nav2_msgs::NavigateToPose>) {
    report_.distance_left = static_cast<double>(message->feedback.distance_remaining);
    const auto& left = message->feedback.estimated_time_remaining;
    report_.time_left = static_cast<double>(left.sec) + 1e-9 * static_cast<double>(left.nanosec);
  } else if constexpr (std::is_same_v<A, nav2_msgs::FollowWaypoints>) {
    report_.waypoint = message->feedback.current_waypoint;
  } else {
    report_.distance_left = static_cast<double>(message->feedback.distance_to_goal);
    const auto speed = static_cast<double>(message->feedback.speed);
    report_.time_left = speed > 0.01 ? report_.distance_left / speed : 0.0;
  }
}

void NavigationClient::receive_cancelled(const Action& action, std::span<const std::uint8_t> payload,
                                         std::int64_t request) {
  constexpr std::int8_t kUnknownGoal = 2;  // or 3, of one that has ended
  const auto response = decode<action_msgs::CancelGoalResponse>(payload, kAnyLayout);
  if (!response || response->return_code < kUnknownGoal) return;  // the status says when it has ended
  const std::scoped_lock lock(mutex_);
  std::erase_if(endings_, [&](const Ending& ending) { return ending.number == request && ending.action == &action; });
}

void NavigationClient::receive_status(std::span<const std::uint8_t> payload) {
  const auto message = decode<action_msgs::GoalStatusArray>(payload, kAnyLayout);
  if (!message) return;
  const std::scoped_lock lock(mutex_);
  for (const GoalStatus& goal : message->status_list) {
    if (goal.status < GoalStatus::kSucceeded) continue;
    std::erase_if(endings_, [&](const Ending& ending) { return ending.id == goal.goal_info.goal_id; });
    if (!is_current(goal.goal_info.goal_id) || current_->final_status) continue;
    current_->final_status = goal.status;
    current_->heard = Clock::now();
  }
}

void NavigationClient::receive_plan(std::span<const std::uint8_t> payload) {
  const auto message = decode<nav_msgs::Path>(payload, kAnyLayout);
  if (!message) return;
  auto plan = std::make_shared<std::vector<Vec2>>();
  for (const auto& stamped : message->poses) plan->push_back({stamped.pose.position.x, stamped.pose.position.y});
  const std::scoped_lock lock(mutex_);
  if (!current_ || current_->goal.way == Way::along_path) return;
  report_.plan = std::move(plan);
}

}  // namespace threewe::ros2
