// World: the robots of one backend world with their autonomy stacks, and the scheduler of robot time.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "threewe/backend/world.hpp"
#include "threewe/core/time.hpp"
#include "threewe/hardware/profile.hpp"
#include "threewe/nav/navigator.hpp"
#include "threewe/slam/localizer.hpp"

namespace threewe {

class Runtime;
class WaitList;

/// Something that becomes true at a tick: a point in robot time, or the end of a motion.
class Wait {
 public:
  virtual ~Wait() = default;
  /// Whether it has come true.
  bool done() const { return done_; }
  /// When it was due: the time slept until, or the tick at which the motion ended.
  Time deadline() const { return deadline_; }
  /// Counts the waits of one world in the order in which they were made.
  std::uint64_t creation() const { return creation_; }

 private:
  friend class WaitList;
  bool done_ = false;
  Time deadline_{};
  std::uint64_t creation_ = 0;
};
/// A wait, shared by all that wait for it.
using WaitHandle = std::shared_ptr<Wait>;

/// Makes the autonomy stack of one robot. A factory that is empty stands for ours.
struct Autonomy {
  /// Makes a localizer for a robot.
  using LocalizerFactory =
      std::function<std::unique_ptr<slam::Localizer>(const RobotProfile& profile, const slam::InitialState& initial)>;
  /// Makes a navigator for a robot.
  using NavigatorFactory = std::function<std::unique_ptr<nav::Navigator>(const RobotProfile& profile)>;
  LocalizerFactory localizer;  ///< empty: ours, the one that `localization` names
  NavigatorFactory navigator;  ///< empty: ours
  /// The localizer's name: states of one are of no use to another. See `autonomy_with`.
  std::string localization = "slam";
  std::string navigation = "own";  ///< the navigator's name, see `autonomy_with`
};

/// Localization by `slam`, our own; by `truth`, where the world is simulated: the robot always knows where it is; or by
/// a program on a real robot, `amcl` or `slam_toolbox`, whose map it is then. Navigation of our `own`, or by `nav2` on
/// a real robot that such a program localises: it drives to positions and along paths, past the safety gate. Throws
/// ConfigError naming the nearest of these.
Autonomy autonomy_with(std::string_view localization, std::string_view navigation = "own");

/// Where one robot is in a world of its own, and which: the options of `Robot`, in C++ and in Python.
struct RobotOptions {
  std::string backend = "mock";              ///< see `backend::backend_names`
  std::string hardware = "3we_standard_v2";  ///< profile, or a file that ends in .yaml
  std::string scene = "office_v2";           ///< simulated place, or a file that ends in .yaml
  NoiseLevel noise = NoiseLevel::realistic;  ///< of sensors and wheels
  std::uint64_t seed = 0;                    ///< of all noise
  bool realtime = false;                     ///< slows a simulator down to the wall clock
  /// A map to be localised in, see `map::load_ros_map`; the robot draws its own where null.
  std::shared_ptr<const map::OccupancyGrid> map = {};
  /// Where the robot starts in its `map` frame. Where empty: at the origin of its own map, anywhere in a given one.
  std::optional<Pose2D> initial_pose = {};
  /// Where it starts in the scene's frame, for simulated worlds; the scene's own start pose where empty.
  std::optional<Pose2D> start_pose = {};
  Autonomy autonomy = {};  ///< ours by default; `autonomy_with("truth")` knows the true pose
  /// What its camera delivers, where that is to be another size than its profile states.
  std::optional<ImageSize> image_size = {};
  /// How the simulated robot differs from its profile, see `models::load_randomization`.
  std::string randomization = "none";
};

/// One backend world with a runtime for each of its robots. Not thread-safe: one thread at a time may use it.
///
/// A tick is one control period (20 ms), and every robot in the world takes part:
///   act     plan, control, gate and command, with what was known at the tick's start
///   advance the backend moves time on by one period
///   sense   poll, localise, tell the observers, end what has ended
/// so that a command given between two ticks takes effect in the very next one.
///
/// A robot that fails ends its motions with `fault` and the others go on. A backend whose `advance_to` throws fails
/// every robot, and `tick`, `run` and `wait` throw ConnectionError from then on until `reset` or `restore`.
class World {
 public:
  /// How a world is made.
  struct Options : backend::WorldOptions {
    std::string backend = "mock";  ///< see `backend::backend_names`
    bool realtime = false;         ///< pace a lockstep world to the wall clock
    Autonomy autonomy;             ///< of every robot
    /// What every robot is localised in; each draws its own where null.
    std::shared_ptr<const map::OccupancyGrid> map;
    /// Where each robot starts in its `map` frame. Where left out: at the origin of its own map, anywhere in a given
    /// one. Robots that are all given one have the same `map` frame: they share what they have mapped, and who goes
    /// where, when they explore.
    std::vector<Pose2D> initial_poses;
  };
  /// Throws HardwareError for a robot without a lidar that is given a map.
  explicit World(const Options& options);
  /// The world of one robot.
  explicit World(const RobotOptions& robot);
  /// Of a backend's world that was made already; arguments as in `Options`.
  explicit World(std::unique_ptr<backend::World> backend, bool realtime = false, const Autonomy& autonomy = {},
                 const std::vector<Pose2D>& initial_poses = {},
                 const std::shared_ptr<const map::OccupancyGrid>& map = nullptr);
  ~World();

  /// How many robots it has.
  std::size_t robot_count() const;
  /// Robot `index`. Throws ContractError where there is none.
  Runtime& robot(std::size_t index);
  /// The same of a const world.
  const Runtime& robot(std::size_t index) const;
  /// The truth about its robots where they are simulated, for metrics, rewards and drawings; null where they are real.
  /// For the holder of the world: a robot, its observers and its autonomy stack see a const world at most.
  const backend::TruthService* truth_service();
  /// Robot time.
  Time now() const;
  /// Of which backend a world is, and how it was made.
  struct Origin {
    std::string backend;            ///< see `backend::backend_names`
    backend::WorldOptions options;  ///< with all names and files as they were given
  };
  /// How to make such a world again; empty for one made from a backend.
  const std::optional<Origin>& origin() const;
  /// Where a robot's `map` frame lies in the scene, for recordings and drawings: no autonomy ever sees it. Empty for a
  /// real robot, and in a given map without an initial pose.
  std::optional<Pose2D> scene_from_map(std::size_t robot);
  /// Who localises and who drives its robots, see `autonomy_with`.
  const Autonomy& autonomy() const;
  /// Of all noise: the one that the world was made with; 0 for a world made from a backend.
  std::uint64_t seed() const;
  /// Disconnects every robot, which ends its motion as `cancelled` and stops it.
  void disconnect();

  /// One control period. Never blocks on anything but the backend and, when paced, the clock. Throws ContractError
  /// while a hold is open.
  void tick();
  /// Ticks until a wait is done, none is pending (where time does not go by on its own), or `wall` has passed. True
  /// when a wait was done. Returns false at once while a hold is open.
  bool run(Duration wall);
  /// Ticks until `wait` is done (C++ programs; Python waits through its pump). Throws instead of waiting for what
  /// cannot happen: ContractError while a hold is open or when the wait is not of this world, ConnectionError when no
  /// robot is connected.
  void wait(const WaitHandle& wait);
  /// Ticks until every connected robot is `ready` (see Runtime).
  void settle();

  /// Becomes done at the first tick at or after now + `duration`, at once when that is now. Throws ContractError on a
  /// negative duration.
  WaitHandle sleep(Duration duration);
  /// The same, but time does not advance for its sake (`has_pending` ignores it): a limit on what others wait for.
  WaitHandle alarm(Duration duration);
  /// Drops a sleep or an alarm that no caller waits for any more: it is never done. A motion is not affected.
  void forget(const WaitHandle& wait);
  /// The waits that were done since the last call, by (deadline, creation).
  std::vector<WaitHandle> take_finished();
  /// True while a sleep has not ended or a motion is in progress.
  bool has_pending() const;
  /// True when time goes by on its own: a real-time backend, or a lockstep one that is paced to the wall clock.
  bool realtime() const;
  /// [wall] until the next tick is due, during which `tick` would block; zero in lockstep and when late.
  Duration due() const;

  /// While a hold is open, robot time stands still, so that thinking takes none. Closing it returns a wait that ends
  /// `charge` later: as if the thought had taken just so long while the robot went on. Holds that overlap stand for
  /// thoughts at the same time: time stands still until the last one closes, and their charges run side by side.
  /// A wait begun inside a hold by the one who opened it can never end; `wait` throws there.
  /// Real-time backends cannot stand still: there a hold changes nothing and closing it charges nothing.
  void open_hold();
  /// Ends a hold; the handle is done when `charge` of robot time has gone by since.
  WaitHandle close_hold(Duration charge);
  /// Whether robot time is held by anyone.
  bool held() const;

  /// Begins anew at time 0 with fresh autonomy stacks: motions end as `cancelled`, sleeps are done at once, alarms go
  /// on with what they had left, holds stay open. Throws ContractError where the backend cannot reset, or from an
  /// observer.
  void reset(const backend::ResetOptions& options);
  /// Teleports a robot to `pose` (scene frame) without its noticing, as a kidnapped robot. Throws ContractError where
  /// the backend cannot, or from an observer; ConfigError when something stands there.
  void teleport(std::size_t robot, const Pose2D& pose);
  /// Everything the future depends on: the backend and every robot's autonomy stack and gate. Throws ContractError
  /// while a motion is in progress, or from an observer. Restoring treats sleeps and alarms as `reset` does.
  struct Snapshot;
  /// Everything that the future depends on. Throws ContractError during a motion, or where the backend cannot save.
  std::shared_ptr<const Snapshot> save() const;
  /// The same without the robots' autonomy, as bytes for a world of the same origin; during a motion, too.
  std::vector<std::byte> save_backend() const;
  /// Goes back to such a state. Throws ContractError where it is of a world that was made otherwise.
  void restore(const std::shared_ptr<const Snapshot>& snapshot);

 private:
  friend class Runtime;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace threewe
