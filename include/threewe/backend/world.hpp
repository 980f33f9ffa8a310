// Backend interface: a world that keeps time and, for each robot, a port that delivers samples and takes a velocity.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "threewe/core/samples.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe::scene {
class TruthView;
}

namespace threewe::backend {

/// What a robot can do, readable before connecting.
struct Features {
  std::vector<SensorInfo> sensors;  ///< in the order of `Sample::sensor`
  Kinematics kinematics{};          ///< which velocities the base can drive
  bool lockstep = false;            ///< time advances only when asked to
  bool deterministic = false;       ///< the same seed and commands give the same samples, to the bit
  bool can_reset = false;           ///< `reset` and moving a robot by hand work
  bool can_save = false;            ///< `save` and `restore` work

  /// Whether any of the sensors is of this type.
  bool has(SensorType type) const;
};

class ExternalLocalizer;
class ExternalNavigator;

/// One robot in a world.
class RobotPort {
 public:
  virtual ~RobotPort() = default;

  /// What the robot has and can do; the same before and after `connect`.
  virtual const Features& features() const = 0;
  /// The robot's data sheet.
  virtual const RobotProfile& profile() const = 0;
  /// Throws ConnectionError when the robot cannot be reached. Connecting twice does nothing.
  virtual void connect() = 0;
  /// Stops the robot and lets it go. Disconnecting twice does nothing.
  virtual void disconnect() = 0;
  /// The samples that arrived since the last call, in order of arrival, `received` set to now.
  /// Throws ConnectionError before `connect` and after `disconnect`.
  virtual std::vector<Sample> poll() = 0;
  /// The body velocity to keep until `valid_until`, when the port itself brings the robot to a stop.
  /// Throws ContractError on a velocity that is not finite or that the base cannot drive.
  virtual void command(const Velocity& velocity, Time valid_until) = 0;

  /// Lets a program on the robot localise it, such as "amcl": it is asked where the robot is from `connect` on, which
  /// fails without it. `map_from_start` is where the robot starts, where that is known. Throws ConfigError where the
  /// backend reaches no such program.
  virtual ExternalLocalizer& delegate_localization(std::string_view program,
                                                   const std::optional<Pose2D>& map_from_start);
  /// The same of navigation, such as "nav2".
  virtual ExternalNavigator& delegate_navigation(std::string_view program);
  /// What is wrong with the way to a connected robot that no sample shows, in words for the user's log; empty while
  /// nothing is known to be.
  virtual std::string link_fault() const { return {}; }
};

/// Ground truth of a simulated world, for metrics, rewards and drawings. It belongs to the world, not to its robots: a
/// port, and so an autonomy stack, has no way to it.
class TruthService {
 public:
  virtual ~TruthService() = default;

  /// About robot `index` < `robot_count()`, for as long as the world lives.
  virtual const scene::TruthView& truth(std::size_t index) const = 0;
};

/// How a world begins anew.
struct ResetOptions {
  std::uint64_t seed = 0;  ///< of all noise and of where people begin
  /// Where each robot starts, in the scene's frame; the scene's own start poses where empty. People who would begin
  /// there begin farther on.
  std::vector<Pose2D> poses = {};  // NOLINT(readability-redundant-member-init): g++ warns where it is left out
  /// Which of the seed's episodes: each has noise and people of its own.
  std::uint32_t episode = 0;
};

/// A world that keeps its own time. Time begins at 0 and returns there on reset.
class World {
 public:
  virtual ~World() = default;

  /// How many robots the world has; never changes.
  virtual std::size_t robot_count() const = 0;
  /// Robot `index` < `robot_count()`.
  virtual RobotPort& robot(std::size_t index) = 0;
  /// The truth about its robots where they are simulated; null where they are real.
  virtual const TruthService* truth_service() const { return nullptr; }
  /// Robot time since the world was made or reset.
  virtual Time now() const = 0;
  /// Lockstep: simulates until `now() == t`. Real time: returns when the clock has reached `t`.
  virtual void advance_to(Time t) = 0;
  /// Throws ContractError where `can_reset` is false, ConfigError when a robot would start inside an obstacle.
  virtual void reset(const ResetOptions& options);
  /// Teleports a robot to `pose`, in the scene's frame, where it stands still. Throws
  /// ContractError where `can_reset` is false or it cannot be done, ConfigError when something stands there.
  virtual void teleport(std::size_t robot, const Pose2D& pose);
  /// Everything that the future depends on. Throws ContractError where `can_save` is false.
  virtual std::vector<std::byte> save() const;
  /// Goes back to what `save` returned. Throws ContractError where `can_save` is false or the state is of another
  /// world.
  virtual void restore(const std::vector<std::byte>& state);
};

/// How a world is made.
struct WorldOptions {
  std::string scene = "office_v2";                        ///< its name, or a file that ends in .yaml
  std::vector<std::string> robots = {"3we_standard_v2"};  ///< one hardware profile per robot
  NoiseLevel noise = NoiseLevel::realistic;               ///< of sensors and wheels
  std::uint64_t seed = 0;                                 ///< of all noise
  /// As in ResetOptions.
  std::vector<Pose2D> poses = {};  // NOLINT(readability-redundant-member-init): g++ warns where it is left out
  /// What the robots' cameras deliver, where that is to be another size than their profiles state.
  std::optional<ImageSize> image_size = {};  // NOLINT(readability-redundant-member-init): likewise
  /// How simulated robots differ from their profiles, see `models::load_randomization`.
  std::string randomization = "none";
  /// The profiles themselves where they are at hand, as in a recording; `robots` are their names then. Simulators alone
  /// take them.
  std::vector<RobotProfile> profiles = {};  // NOLINT(readability-redundant-member-init): likewise
};

}  // namespace threewe::backend
