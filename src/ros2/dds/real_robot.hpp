// Real robot: its topics, as a plug-in of the backend contract that answers in a thread of its own.
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "backend/plugin.hpp"
#include "ros2/dds/localization_client.hpp"
#include "ros2/dds/navigation_client.hpp"
#include "ros2/dds/node.hpp"
#include "ros2/readings.hpp"
#include "ros2/stamp_clock.hpp"

namespace threewe::ros2 {

/// What a robot of this profile has over its link. Throws ConfigError for a profile without one.
backend::Features features_of(const RobotProfile& profile);

/// Talks to one robot. Readings go into the mailbox as they arrive, in threads of the middleware's; velocities go out
/// with each step that the mailbox asks for, 50 times a second.
class RealRobot {
 public:
  RealRobot(std::shared_ptr<backend::PluginLink> mailbox, Discovery discovery);

  /// As RobotPort's, before it is first connected. Throws ConfigError naming the nearest of the programs.
  backend::ExternalLocalizer& delegate_localization(std::string_view program,
                                                    const std::optional<Pose2D>& map_from_start);
  backend::ExternalNavigator& delegate_navigation(std::string_view program);

  /// Answers the mailbox until its world is gone.
  void run();

 private:
  using Clock = std::chrono::steady_clock;
  // What is known of one topic; behind the mutex.
  struct Source {
    TopicSpec topic;
    std::size_t sensor = 0;  // in the features
    Node::Handle handle;
    std::uint64_t publisher = 0;  // whose messages are taken
    Time newest{};                // robot time, when the last of them came
    std::optional<Time> rival{};  // when another publisher's did
    bool delivered = false;
    std::string mistake;        // in the last message that was refused
    std::string contradiction;  // of the last message and the profile
  };

  void connect();
  void wait_until_reached();
  std::string missing();
  std::string silence();
  std::string missing_command(const std::vector<Endpoint>& endpoints);
  std::string missing_readings(const Source& source, const std::vector<Endpoint>& endpoints);
  std::string mistake_in_command(const std::vector<Endpoint>& endpoints) const;
  std::string mistake_in(const Source& source, const std::vector<Endpoint>& endpoints) const;
  std::vector<Source> sources();
  void disconnect();
  void send(const Velocity& velocity);
  builtin_interfaces::Time robot_stamp();
  void watch();
  std::string lost_images(const Source& source);
  void subscribe(std::size_t source);
  void subscribe_to_static_frames();
  void receive(std::size_t source, std::span<const std::uint8_t> payload, std::uint64_t publisher);
  bool admit(Source& source, std::uint64_t publisher, Time arrival);
  std::optional<ReadingOrMistake> read(Source& source, std::span<const std::uint8_t> payload, std::uint64_t publisher,
                                       Time arrival);
  Duration patience(const Source& source) const;
  void place_odometry(Odometry& odometry);

  const std::shared_ptr<backend::PluginLink> mailbox_;
  const Discovery discovery_;
  const RobotProfile& profile_;
  const LinkSpec& link_;
  TopicSpec command_topic_;              // as the robot takes it
  std::optional<Node::Handle> command_;  // once that is known
  Node::Handle diagnostics_;
  Clock::time_point begun_{};  // when it was last connected
  int steps_ = 0;
  std::unique_ptr<LocalizationClient> localization_;  // null: it is localised by us
  std::unique_ptr<NavigationClient> navigation_;      // null: we drive it

  std::mutex mutex_;
  std::condition_variable arrived_;
  std::vector<Source> sources_;
  StampClock clock_;
  TransformOdometry transforms_;
  StaticFrames static_frames_;
  std::optional<PictureMaker> pictures_;
  std::optional<Pose2D> odom_from_theirs_;  // empty until the first odometry message
  Pose2D odom_from_base_;
  std::unique_ptr<Node> node_;  // last: receivers end before what they use
};

}  // namespace threewe::ros2
