// Backends that run in a thread of their own and answer requests: how Python, or any code that we do not trust to
// return, becomes a backend.
//
//   runtime's thread                     plug-in's thread
//   PluginWorld --- PluginLink (mailbox) --- take() ... answer() or fail()
//
// No thread holds a lock while the plug-in runs. A plug-in that raises, answers what breaks the contract, or does not
// come back is at fault: `poll` and `command` then throw, `advance_to` lets time go by, and the plug-in is asked to
// disconnect as soon as it listens again. `connect` makes a new attempt.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "threewe/backend/world.hpp"
#include "threewe/scene/truth_view.hpp"

namespace threewe::backend {

/// What a plug-in is asked to do.
struct PluginRequest {
  enum class Call : std::uint8_t { connect, disconnect, step, reset, save, restore, truth };
  Call call{};
  /// step: lockstep simulates until then; in real time it is now
  Time t{};
  /// step: to drive at; finite, within the hardware limits, zero once expired
  Velocity velocity{};
  /// reset
  std::uint64_t seed = 0;
  /// reset: where to start, in the scene's frame
  std::optional<Pose2D> pose = {};  // NOLINT(readability-redundant-member-init): g++ warns where it is left out
  /// restore
  std::vector<std::byte> state = {};  // NOLINT(readability-redundant-member-init): g++ warns where it is left out
};
std::string_view to_string(PluginRequest::Call call);

/// One measurement, before it has a sequence number and a time of arrival.
struct PluginReading {
  std::string sensor;  ///< a name in `Features::sensors`
  Time measured{};
  SampleData data;
};

/// What a simulator knows about its robot, in the scene's frame, and no robot does: see scene::TruthView.
struct PluginTruth {
  Pose2D start;
  Pose2D pose;
  Velocity velocity;
  double distance_driven = 0.0;      ///< [m]
  double max_collision_speed = 0.0;  ///< [m/s]
};

/// What it answers. Empty but for `step`, `save` and `truth`.
struct PluginReply {
  std::vector<PluginReading> readings;  ///< step
  std::vector<std::byte> state;         ///< save
  PluginTruth truth = {};               // NOLINT(readability-redundant-member-init): g++ warns where it is left out
};

/// The mailbox between a world and its plug-in. Both sides share it, so that either may end first.
class PluginLink {
 public:
  /// `name` stands for the plug-in in messages; `patience` is the wall time that one call may take (connecting to real
  /// hardware: 15 times as long). Throws ContractError when the features contradict themselves or the profile.
  PluginLink(std::string name, Features features, RobotProfile profile, Duration patience = 2s);

  const Features& features() const { return features_; }
  const RobotProfile& profile() const { return profile_; }
  /// Asks a simulator, once for each moment in lockstep. Throws ConnectionError or ContractError where it is at fault.
  PluginTruth truth();
  /// Tells the plug-in to disconnect and its thread to end, and waits for neither.
  void close();

  // For the plug-in's thread, in turn: `take`, then `answer` or one of the failures.

  /// Waits for the next request; in real time one to step comes every control period. Empty when the world is gone and
  /// the thread shall end.
  std::optional<PluginRequest> take();
  void answer(PluginReply reply);
  /// The plug-in raised.
  void fail(const std::string& what);
  /// The plug-in answered with something that cannot even be converted to a reply.
  void refuse(const std::string& what);

  // For any thread of the plug-in's, at any time.

  /// Robot time.
  Time robot_time() const;
  /// Lets a reading of a connected robot in real time arrive, without waiting for the next step.
  void push(PluginReading reading);
  /// What `RobotPort::link_fault` says from now on, until it is connected anew.
  void note_link_fault(std::string words);

 private:
  friend class PluginWorld;
  using Clock = std::chrono::steady_clock;
  using Lock = std::unique_lock<std::mutex>;
  struct Fault {
    bool contract = false;  // thrown as ContractError, else as ConnectionError
    std::string what;
  };
  struct Command {
    Velocity velocity;
    Time valid_until{};
  };

  // the world's side; all need the lock
  bool exchange(Lock& lock, PluginRequest request);
  PluginReply ask(Lock& lock, PluginRequest request);
  bool wait_until_idle(Lock& lock);
  void notice_hanging();
  void throw_if_faulty() const;
  void begin_anew();
  Time now() const;
  Velocity velocity_at(Time t) const;
  Duration patience(PluginRequest::Call call) const;

  // the plug-in's side
  std::optional<PluginRequest> next_request();
  void finish(std::optional<Fault> fault, PluginReply reply);
  std::optional<Fault> deliver(std::vector<PluginReading> readings);
  std::optional<Fault> find_fault(const PluginTruth& truth) const;

  const std::string name_;
  const Features features_;
  const RobotProfile profile_;
  const Duration patience_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;

  // robot time: `lockstep_now_`, or the wall clock since `origin_`
  Time lockstep_now_{};
  Clock::time_point origin_ = Clock::now();

  // the mailbox
  std::optional<PluginRequest> posted_;   // by the world, not taken yet
  std::optional<PluginRequest> current_;  // taken, not finished yet; written by the plug-in's thread alone
  std::optional<PluginReply> reply_;      // to what the world posted
  Time give_up_{};                        // in real time, when `current_` counts as hanging
  bool plugin_connected_ = false;         // it has answered `connect`, and has not been asked to disconnect since
  bool quit_ = false;

  // the robot
  bool connected_ = false;
  std::optional<Fault> fault_;
  std::string link_fault_;
  Command command_;
  Time next_step_{};  // in real time
  std::vector<Sample> arrived_;
  std::vector<std::uint64_t> sequence_;  // of each sensor's next sample
  std::vector<Time> newest_;             // stamp of each sensor
  std::optional<PluginTruth> truth_;     // until something happens
};

/// A world with one robot, whose other end is a plug-in; a simulator's comes with a view of what it answers to `truth`.
class PluginWorld : public World, private RobotPort, private TruthService {
 public:
  explicit PluginWorld(std::shared_ptr<PluginLink> link, std::unique_ptr<const scene::TruthView> truth = nullptr);
  ~PluginWorld() override { link_->close(); }
  PluginWorld(const PluginWorld&) = delete;
  PluginWorld& operator=(const PluginWorld&) = delete;

  std::size_t robot_count() const override { return 1; }
  RobotPort& robot(std::size_t index) override;
  const TruthService* truth_service() const override { return truth_ ? this : nullptr; }
  Time now() const override;
  void advance_to(Time t) override;
  void reset(const ResetOptions& options) override;
  std::vector<std::byte> save() const override;
  void restore(const std::vector<std::byte>& state) override;

 private:
  const Features& features() const override { return link_->features_; }
  const RobotProfile& profile() const override { return link_->profile_; }
  void connect() override;
  void disconnect() override;
  std::vector<Sample> poll() override;
  void command(const Velocity& velocity, Time valid_until) override;
  std::string link_fault() const override;
  const scene::TruthView& truth(std::size_t) const override { return *truth_; }

  std::shared_ptr<PluginLink> link_;
  std::unique_ptr<const scene::TruthView> truth_;
};

}  // namespace threewe::backend
