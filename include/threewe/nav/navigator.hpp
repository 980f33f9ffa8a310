// Navigator interface: planning and control from a goal to velocities. The runtime knows this interface alone, so that
// an external navigation can stand in for ours.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"
#include "threewe/map/occupancy_grid.hpp"
#include "threewe/map/zone.hpp"
#include "threewe/perception/percepts.hpp"
#include "threewe/slam/localizer.hpp"

namespace threewe::nav {

/// How a motion ends, and why.
enum class Reason : std::uint8_t {
  running,
  reached,
  no_path,
  blocked,
  timeout,
  cancelled,
  estop,
  lost,
  uncertain,
  fault,
  starved,      ///< what steers it wants nothing any more, see `Runtime::drive`
  policy_error  ///< what steers it failed
};
/// Its name, such as "reached".
std::string_view to_string(Reason reason);

// A motion aims at its goal itself, a few centimetres and a degree or two. Its tolerances say how far off it may end
// where something keeps it from getting any nearer; one that is finer than that is aimed at instead.

/// Drive to a position in `map`, and turn to a heading where one is given.
struct MoveTo {
  Vec2 goal;                      ///< [m] in `map`
  std::optional<double> theta{};  ///< [rad]
  double tolerance = 0.25;        ///< [m]
  double angle_tolerance = 0.1;   ///< [rad]
};
/// Turn on the spot by `angle` [rad], counter-clockwise; may exceed a full turn.
struct Rotate {
  double angle = 0.0;            ///< [rad]
  double angle_tolerance = 0.1;  ///< [rad]
};
/// Drive straight ahead by `distance` [m], backwards when negative.
struct MoveForward {
  double distance = 0.0;    ///< [m]
  double tolerance = 0.05;  ///< [m]
};
/// Drive along a polyline in `map`.
struct FollowPath {
  std::vector<Vec2> path;   ///< [m] in `map`, from the first point to the last
  double tolerance = 0.25;  ///< [m] about the last point
};
/// Drive to places in `map` one after the other, by whatever way, and stop at each. The first that is missed ends it.
struct FollowWaypoints {
  std::vector<MoveTo> waypoints;  ///< in their order
};
/// Map what can be reached and is worth the way; all of it, where it is `thorough`.
struct Explore {
  bool thorough = false;  ///< also the last corners, which may take as long as all the rest
  /// [m] of way, from 0 to `most_worth`, that a place in `map` is worth beside what can be seen there; asked as the
  /// robot goes on, so that what it learns on its way may count. Empty: no place is.
  std::function<double(Vec2)> worth{};
  double most_worth = 0.0;  ///< [m] of any place
};

/// Any motion.
using Goal = std::variant<MoveTo, Rotate, MoveForward, FollowPath, FollowWaypoints, Explore>;

/// What another robot tells that has the same `map` frame.
struct Peer {
  std::string name{};                       ///< what results call it
  Pose2D map_from_base{};                   ///< where it believes that it is
  Velocity velocity{};                      ///< of its base
  double radius = 0.0;                      ///< [m] of a disc around its body
  std::optional<Vec2> bound_for{};          ///< [m] the end of the path that it follows, in `map`
  const map::OccupancyGrid* map = nullptr;  ///< what it has mapped
};

/// What the navigator sees at one tick.
struct Observation {
  Time now{};                     ///< without the time that the robot stood for a sensor
  slam::PoseEstimate pose;        ///< in `map` and `odom`, with its covariance
  const map::OccupancyGrid& map;  ///< that the localizer has drawn
  std::uint64_t map_version = 0;  ///< counts its changes
  /// Where the newest scan hit something: points in the `odom` frame, deskewed.
  std::span<const Vec2> obstacles;
  /// Where the map has changed, version by version; null where unknown.
  const map::ChangeLog* map_changes = nullptr;
  std::span<const Peer> peers{};  ///< robots with the same map frame
  /// Who walks around the robot now, in `odom`; empty without a lidar.
  std::span<const perception::TrackedPerson> people{};
  /// The command of the period before, as the gate let it through.
  Velocity commanded{};
};

/// What a robot does that does not get on: in this order, as often as it takes or until it gives up.
enum class RecoveryState : std::uint8_t {
  driving,      ///< it gets on
  clearing,     ///< stands still until what it sees is fresh
  backing_off,  ///< the way it came, or where there is most room
  arc_escape,   ///< where it cannot turn: out in arcs, forwards and backwards
  looking,      ///< turns to look; all the way round where it is lost
  replanning,   ///< plans anew, for one period
  given_up,     ///< the result's `detail` says why
};
/// Its name, such as "backing_off".
std::string_view to_string(RecoveryState state);

/// How far a motion has come.
struct Progress {
  double distance_left = 0.0;    ///< [m] along the path; when exploring to the next frontier
  double time_left = 0.0;        ///< [s] that this, and turning to a heading, will take at the mean speed so far
  double distance_driven = 0.0;  ///< [m] since the start of the motion
  Pose2D pose;                   ///< in `map`
  RecoveryState recovery = RecoveryState::driving;  ///< what the robot is doing to get on
};

/// What the navigator wants.
struct Decision {
  Velocity velocity;                ///< in the body frame
  Reason reason = Reason::running;  ///< `running`, or why the motion is over
  std::string detail{};             ///< says more about a failure; may be empty
  /// Asks for creep mode: slowly, and nearer to the sides of a narrow passage than the robot would come else, where the
  /// safety gate measures that the robot passes them.
  bool creep_mode = false;
};

/// A plan, and the samples of which it is the weighted mean. Poses in `odom`, at the ends of the steps; velocities in
/// the body frame, as they are asked for: the poses are where these lead within the limits of the base.
struct SampledPlan {
  Time made{};                         ///< it begins a little later, when its first command takes effect
  double step = 0.0;                   ///< [s]
  std::vector<Pose2D> poses{};         ///< (steps,) where the plan leads
  std::vector<Velocity> velocities{};  ///< (steps,) what it asks for
  std::vector<Pose2D> trajectories{};  ///< (samples, steps) where each sample leads
  std::vector<Velocity> controls{};    ///< (samples, steps) what each asks for
  std::vector<double> weights{};       ///< (samples,) how much each counts; 1 in all
};

/// Planning and control of one robot. It sees estimates and scans, never the truth.
class Navigator {
 public:
  virtual ~Navigator() = default;

  /// Begins a motion; the one before is forgotten.
  virtual void start(const Goal& goal, const Observation& observation) = 0;
  /// One control period of the motion.
  virtual Decision step(const Observation& observation) = 0;
  /// The motion has ended, for whatever reason.
  virtual void end() {}
  /// Whether another program drives the robot in this motion, past the safety gate.
  virtual bool drives_past_the_gate() const { return false; }
  /// How far the motion has come.
  virtual Progress progress() const = 0;
  /// Where the robot may not go, or only slowly, in `map`: from now on, in place of what was set before.
  virtual void set_zones(const std::vector<map::Zone>& zones) = 0;
  /// The path being followed, in `map`, from the robot to its goal; empty between motions.
  virtual std::span<const Vec2> path() const = 0;
  /// The plan followed in the last period and its samples, put together for a caller that asks; empty where none was,
  /// and of navigators that do not sample any.
  virtual std::optional<SampledPlan> plan() const { return {}; }
  /// A copy that lives on independently, for saving and restoring.
  virtual std::unique_ptr<Navigator> clone() const = 0;
};

}  // namespace threewe::nav
