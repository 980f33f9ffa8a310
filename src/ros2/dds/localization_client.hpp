// Client of SLAM Toolbox and AMCL: the robot's place, as transform, covariance and map.
#pragma once

#include <functional>
#include <mutex>
#include <optional>
#include <string>

#include "backend/delegation.hpp"
#include "ros2/dds/node.hpp"
#include "ros2/messages/nav_msgs.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe::ros2 {

/// The names of the programs that can localise a robot.
inline constexpr std::array<std::string_view, 2> kLocalizationPrograms{"amcl", "slam_toolbox"};

/// What one of these says, on the topics of a link. What arrives is noted in threads of Cyclone's.
class LocalizationClient : public backend::ExternalLocalizer {
 public:
  /// `initial_pose` is published to the program, where it is known.
  LocalizationClient(std::string program, const LinkSpec& link, const std::optional<Pose2D>& initial_pose,
                     std::function<Time()> robot_time);

  /// Begins anew, with a node.
  void connect(Node& node);
  /// What has not come since; empty once all is there.
  std::string missing(Node& node);
  /// Once a control period, in the node's thread.
  void step(Node& node);
  /// Where the odometry of the samples has that of the transforms.
  void place(const Pose2D& odom_from_theirs);
  Report report() const override;

 private:
  void receive(const tf2_msgs::TFMessage& message);
  void receive(const geometry_msgs::PoseWithCovarianceStamped& message);
  void receive(const nav_msgs::OccupancyGrid& message);
  template <Message T>
  void subscribe(Node& node, const std::string& topic, const Qos& qos);

  const std::string program_;
  const std::string name_space_, map_frame_, odom_frame_;
  const std::string no_transform_;  // in words
  const std::optional<Pose2D> initial_pose_;
  const std::function<Time()> robot_time_;
  std::optional<Node::Handle> initial_;  // where its initial pose is published until it has been

  mutable std::mutex mutex_;
  Report report_;
  std::optional<Pose2D> map_from_theirs_;
  Pose2D odom_from_theirs_;
  std::string refused_;  // what was wrong with the newest map
};

}  // namespace threewe::ros2
