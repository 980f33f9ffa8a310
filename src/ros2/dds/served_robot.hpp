// One simulated robot as a ROS 2 node: what it publishes, and the commands that it takes.
#pragma once

#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <string>

#include "ros2/dds/node.hpp"
#include "ros2/serve.hpp"
#include "threewe/backend/world.hpp"
#include "threewe/scene/truth_view.hpp"

namespace threewe::ros2 {

/// Lets a server wait for commands of any of its robots.
struct Bell {
  std::mutex mutex;
  std::condition_variable rung;
};

/// A robot of a world, connected. Commands arrive in threads of the middleware's; all else is one thread's.
class ServedRobot {
 public:
  /// `index` is the robot's in its world, `name_space` empty or such as "/robot_1".
  ServedRobot(backend::World& world, const backend::TruthService& truth, std::size_t index,
              const std::string& name_space, const ServeOptions& options, const Discovery& discovery, Bell& bell);

  /// Drives at the last command that came, for as long as it holds from now on.
  void drive(Time now);
  /// Drives at the first command of those that wait, for one control period. It must have one.
  void step(Time now);
  /// Whether a command waits. The bell's mutex must be held.
  bool has_command() const { return !commands_.empty(); }
  /// Publishes what the sensors delivered.
  void publish();
  void publish_clock(Time now);
  /// Announces the node again to those that read another layout.
  void refresh() { node_.refresh(); }

 private:
  // What a sensor's samples are published as; a camera has several.
  struct Outlets {
    std::optional<Node::Handle> main, compressed, depth, info;
    std::string frame;
  };
  Outlets advertise(const SensorInfo& sensor);
  template <Message T>
  void receive(const std::string& topic);
  void send(const Sample& sample);
  void send_picture(const Outlets& outlets, const std_msgs::Header& header, const Picture& picture);
  void send_transforms(const Sample& sample, const Odometry& odometry);
  void show_autonomy();
  void diagnose();
  void begin_goal();
  template <Message T>
  void send(std::optional<Node::Handle> outlet, const T& message);
  std::string topic_of(const SensorInfo& sensor) const;

  backend::RobotPort& port_;
  backend::World& world_;
  const scene::TruthView& truth_;
  const RobotProfile& profile_;
  const std::string name_space_;
  const bool with_map_, in_lockstep_;
  const int depth_;  // of small messages: in lockstep none is lost
  const std::string odom_frame_, base_frame_;
  const Duration watchdog_;
  Bell& bell_;
  std::deque<Velocity> commands_;                       // behind the bell's mutex
  std::optional<std::pair<std::string, Pose2D>> goal_;  // likewise: the newest that has come, and its frame
  ServedAutonomy* const autonomy_;                      // null where it has none
  std::optional<std::uint64_t> map_version_;            // that was published
  Time shown_{};                                        // when it was last looked at
  bool has_plan_ = false;                               // is published
  int pictures_ = 0;
  std::vector<Outlets> outlets_;             // by the index of the sensor
  std::vector<std::optional<Time>> newest_;  // likewise: when its last sample came
  Time diagnosed_{};
  std::optional<Node::Handle> clock_, transforms_, map_, plan_, diagnostics_;
  Node node_;  // last: receivers end before what they use
};

}  // namespace threewe::ros2
