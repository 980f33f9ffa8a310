// Robot in a world of Gazebo, as a plug-in of the backend contract: steps the world in lockstep, and reads its topics.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "backend/plugin.hpp"
#include "gazebo/node.hpp"
#include "gazebo/readings.hpp"

namespace threewe::gazebo {

/// What Gazebo gives of a robot of this profile: all but the battery.
backend::Features features_of(const RobotProfile& profile);

/// The robot of an exported world, in a thread of its own. Names of topics are those of the export.
///
/// A step is asked for by the world's control service, which answers as soon as it has queued it. The clock says that
/// it is done: it is sent at the beginning of each of Gazebo's steps, and again and again while the world is paused, so
/// that a time that comes twice has passed. By then all that was measured in the step has come, too, but for what is
/// drawn (lidars and cameras), by a thread of Gazebo's own: that is due at known times, and waited for.
class Robot {
 public:
  Robot(std::shared_ptr<backend::PluginLink> mailbox, Settings settings, const std::string& world, Pose2D start);

  /// Answers the mailbox until its world is gone.
  void run();

 private:
  using WallClock = std::chrono::steady_clock;
  // One topic of a sensor; behind the mutex but for what never changes.
  struct Source {
    std::string sensor;
    std::string topic;
    const char* type = "";
    Duration period{};       // as Gazebo has it
    bool drawn = false;      // by its rendering
    std::int64_t turn = 0;   // of its updates, those whose number ...
    std::int64_t turns = 1;  // ... by this leaves that are readings
    std::function<std::optional<ReadingOrMistake>(ByteView)> read;
    Time newest{};
    bool delivered = false;
    std::string mistake;  // in the last message that was refused
  };
  struct Arrived {
    std::size_t source = 0;
    Reading reading;
  };
  struct Truth {
    Time stamp{};
    Pose2D pose;
    Velocity velocity;
  };

  /// What has not delivered yet.
  struct Silent {
    std::vector<std::string> ones;  // and why
    bool wrong = false;             // one of them delivers what is refused
  };

  // answers
  void connect();
  std::vector<backend::PluginReading> step(Time t, const Velocity& velocity);
  void reset(const std::optional<Pose2D>& pose);
  void disconnect();
  backend::PluginTruth truth();

  // connecting
  void make_sources();
  void subscribe();
  void find_all();
  std::string missing() const;
  std::string other_worlds() const;
  void measure_step();
  void hear_all();
  Silent silent_ones() const;

  // stepping
  void control(std::uint32_t steps = 0, const std::optional<msgs::WorldReset>& reset = {});
  void ask(const std::string& service, const char* type, ByteView request);
  [[noreturn]] void fail(const std::string& seen) const;
  void drive(const Velocity& velocity);
  void pause();
  void simulate(Time until);
  void wait_for_clock(const std::function<bool()>& reached, const std::string& what);
  void wait_for_drawn();
  std::vector<backend::PluginReading> take_readings();

  // episodes
  void put_down(const Pose2D& pose);
  void begin();

  // in the node's thread
  void receive_clock(ByteView message);
  void receive_truth(ByteView message);
  void receive_contacts(ByteView message);
  void receive(std::size_t source, ByteView message);

  const std::shared_ptr<backend::PluginLink> mailbox_;
  const Settings settings_;
  const RobotProfile& profile_;
  const std::string world_;  // its topics: "/world/NAME"
  Pose2D start_;             // commanded, until it stands there

  bool begun_ = false;  // the world was reset once
  Time origin_{};       // simulated time at which robot time began
  Duration step_{};     // of Gazebo's physics
  Velocity commanded_;  // what was sent last ...
  bool known_ = false;  // ... to this simulator
  Time time_{};         // simulated until then
  Pose2D odom_from_base_;
  std::optional<Pose2D> odom_from_theirs_;

  mutable std::mutex mutex_;  // of what follows, and of the sources
  std::condition_variable arrived_;
  std::vector<Source> sources_;
  std::optional<PictureMaker> pictures_;
  std::vector<Arrived> readings_;
  Time clock_{};
  std::uint64_t clocks_ = 0;   // that came
  std::uint64_t repeats_ = 0;  // of them with the time of the one before
  std::optional<Truth> truth_;
  std::deque<Truth> recent_;      // the truths of some steps, oldest first
  double distance_ = 0.0;         // [m] driven
  double collision_speed_ = 0.0;  // [m/s], the largest
  std::string truth_mistake_;
  std::unique_ptr<Node> node_;  // last: its thread uses what is above
};

}  // namespace threewe::gazebo
