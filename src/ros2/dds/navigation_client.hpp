// Client of Nav2's actions NavigateToPose, FollowPath and FollowWaypoints.
#pragma once

#include <chrono>
#include <mutex>
#include <optional>
#include <random>
#include <string>

#include "backend/delegation.hpp"
#include "ros2/dds/node.hpp"
#include "ros2/messages/action_msgs.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe::ros2 {

/// One goal at a time. Requests go out in the node's thread with each step, and what arrives is noted in threads of
/// Cyclone's; no answer is waited for.
class NavigationClient : public backend::ExternalNavigator {
 public:
  explicit NavigationClient(const LinkSpec& link);

  /// Begins anew, with a node.
  void connect(Node& node);
  /// What is not there; empty once a goal can be sent.
  std::string missing(Node& node);
  /// Once a control period, in the node's thread.
  void step(Node& node);
  /// Cancels a goal in progress and waits until that has been received.
  void release(Node& node);
  /// Whether it has the robot: no velocity may be sent meanwhile.
  bool drives() const;

  void start(const Goal& goal) override;
  void cancel() override;
  Report report() const override;
  std::string trouble() const override;

 private:
  using Clock = std::chrono::steady_clock;
  using UUID = unique_identifier_msgs::UUID;
  // How to talk of goals of one kind.
  struct Action {
    std::string name;             // with its namespace
    std::string_view reply_type;  // of the result, which differs by distribution
    Node::Client send, result, cancel;
    Node::Handle feedback, status;
  };
  // The newest goal, from when it is wanted.
  struct Current {
    Goal goal;
    UUID id;
    const Action* action = nullptr;  // null until it has been sent
    Distribution layout{};
    std::int64_t send_number = 0, result_number = 0;
    bool accepted = false;
    std::optional<std::int8_t> final_status;
    Clock::time_point heard{};  // of its server
  };
  // A goal that is to be cancelled, until its server says that it has ended or that it knows of none.
  struct Ending {
    UUID id;
    const Action* action = nullptr;
    Clock::time_point since{};
    Clock::time_point sent{};
    std::int64_t number = 0;  // of the newest request
  };

  template <typename A>
  Action& action_of();
  template <typename A>
  void connect(Node& node);
  template <typename A>
  void receive_acceptance(std::span<const std::uint8_t> payload, std::int64_t request);
  template <typename A>
  void receive_result(std::span<const std::uint8_t> payload, std::int64_t request);
  template <typename A>
  void receive_feedback(std::span<const std::uint8_t> payload);
  void receive_cancelled(const Action& action, std::span<const std::uint8_t> payload, std::int64_t request);
  void receive_status(std::span<const std::uint8_t> payload);
  void receive_plan(std::span<const std::uint8_t> payload);

  void send_goal(Node& node);
  void send_cancel(Node& node);
  void ask_for_result(Node& node);
  void watch(Node& node);
  void finish(Outcome outcome, const std::string& detail);
  void end_at_server();
  void finish_by(const nav2_msgs::FollowWaypointsResult& result, bool succeeded);
  bool is_current(const UUID& id) const { return current_ && current_->action != nullptr && current_->id == id; }

  const std::string name_space_, map_frame_;
  Action to_pose_, along_path_, to_waypoints_;
  std::mt19937_64 random_{std::random_device{}()};

  mutable std::mutex mutex_;
  std::optional<Current> current_;  // while it is in progress
  std::vector<Ending> endings_;
  Report report_;
  std::string trouble_;
};

}  // namespace threewe::ros2
