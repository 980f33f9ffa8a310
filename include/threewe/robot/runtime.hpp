// Runtime of one robot: the only place where autonomy stack, safety gate and backend port come together.
#pragma once

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "threewe/backend/world.hpp"
#include "threewe/nav/navigator.hpp"
#include "threewe/perception/percepts.hpp"
#include "threewe/robot/results.hpp"
#include "threewe/robot/world.hpp"
#include "threewe/safety/intervention.hpp"
#include "threewe/slam/localizer.hpp"

namespace threewe {

using perception::SensorFault;
using perception::SensorHealth;

/// A motion in progress. The handle may outlive the robot.
class Motion : public Wait {
 public:
  /// How far it has come; the last state once done.
  const Progress& progress() const { return progress_; }
  /// Ends the motion with `cancelled` at once and commands zero in the next period. Does nothing once done.
  void cancel();
  /// Throws ContractError before `done()`.
  const MoveResult& result() const;
  /// The same for an exploration.
  ExploreResult explore_result() const;

 private:
  friend class Runtime;
  Runtime* runtime_ = nullptr;  // while in progress
  Progress progress_;
  MoveResult result_;
  double explored_area_ = 0.0;
};
/// A motion, shared by all that wait for it.
using MotionHandle = std::shared_ptr<Motion>;

/// What an observer sees at the end of every tick. References are valid during the call only.
struct TickView {
  Time now{};                           ///< at the end of the tick
  std::span<const Sample> samples;      ///< that arrived in this tick
  const slam::PoseEstimate& pose;       ///< after this tick's samples
  const Velocity& requested;            ///< before the gate
  const safety::GateOutput& commanded;  ///< after it
  const Runtime& robot;                 ///< whose tick it is
};
/// What `Runtime::observe` calls at the end of every tick. It may not let robot time go by.
using Observer = std::function<void(const TickView&)>;

/// Steers a robot: what it wants in the control period that begins at `now`, in the body frame, until its reason is no
/// longer `running`. It sees what it likes, but may not let robot time go by.
using VelocitySource = std::function<nav::Decision(Time now)>;

/// One robot. Everything it does passes through here; see `Robot` for the calls that users make.
class Runtime {
 public:
  /// The autonomy stack of the robot.
  struct Options {
    std::unique_ptr<slam::Localizer> localizer;  ///< never null
    std::unique_ptr<nav::Navigator> navigator;   ///< never null
  };
  /// Of a robot of `world` behind `port`, not connected yet.
  Runtime(World& world, backend::RobotPort& port, Options autonomy);
  ~Runtime();

  /// Connects the port and clears a fault. Throws ConnectionError. The first samples arrive within a few ticks: wait
  /// for `ready` before reading.
  void connect();
  /// Ends a motion as `cancelled` and stops the robot.
  void disconnect();
  /// Whether it is connected.
  bool connected() const;
  /// Becomes done when every sensor has delivered, or 2 s later.
  WaitHandle ready();
  /// Why the robot failed; empty while it is healthy.
  const std::string& fault() const;
  /// The robot's data sheet.
  const RobotProfile& profile() const;
  /// What the backend says of it.
  const backend::Features& features() const;
  /// The world that it is in.
  const World& world() const;

  // Readings: what arrived last. They never advance time. Throw ConnectionError when not connected, HardwareError
  // naming the sensor that is missing or has not delivered yet.
  /// The newest scan.
  const LaserScan& lidar_scan() const;
  /// The newest reading of the inertial unit.
  const IMUData& imu() const;
  /// Pose and velocity by the wheels alone.
  const Odometry& odometry() const;
  /// The newest reading of the battery.
  const BatteryState& battery() const;
  /// The newest image of the camera of that name, drawn now where a simulator has not drawn it yet.
  const RGBDImage& image(std::string_view camera = "camera") const;
  /// The same of a camera that measures depth.
  const RGBDImage& rgbd_image() const;
  std::map<std::string, RangeData> ultrasonic_ranges() const;  ///< by the sensors' names
  /// The newest sample of a kind of sensor, with its stamps.
  const Sample& sample(SensorType type) const;
  /// The pose estimate after the newest tick.
  const slam::PoseEstimate& pose() const;
  /// The map so far; valid until the next tick.
  const map::OccupancyGrid& map() const;
  /// Counts the map's changes: equal numbers mean equal maps.
  std::uint64_t map_version() const;
  /// The path being followed, in `map`.
  std::span<const Vec2> path() const;
  /// The plan being followed, with the samples of which it is the mean; empty while nothing is followed by a plan.
  /// Rolled out on demand: no one else pays for it, and nothing changes.
  std::optional<nav::SampledPlan> plan() const;
  /// `target_from_source` among `map`, `odom`, `base` and the sensors' names. Throws ContractError naming the nearest.
  Pose2D transform(std::string_view target, std::string_view source) const;
  /// What its collision monitor looks out for: where the newest scan, or sonar returns, hit something, in `odom`.
  std::span<const Vec2> obstacles() const;
  /// Who walks around the robot, as its lidar sees them, in `odom`; one who has stood for some seconds is left out.
  std::span<const perception::TrackedPerson> people() const;
  /// How each sensor is. One that the robot needs and that is at fault keeps it still: a motion waits for up to 10 s,
  /// and goes on when the sensor is ok again. What a sensor at fault delivers is not used.
  const std::vector<SensorHealth>& health() const;
  /// What was asked of the gate in the last tick, and what it let through.
  const Velocity& requested() const;
  /// What the gate let through in the last tick, and why.
  const safety::GateOutput& commanded() const;

  /// Drives at `velocity` for at most `hold`, which then stops the robot and warns once. Throws ContractError on a
  /// velocity that is not finite or that the base cannot drive, EmergencyStopError while the stop is latched,
  /// SafetyError while a motion owns the robot.
  /// With `creep_mode` it drives slowly, and may pass nearer to the sides of a narrow passage.
  void set_velocity(const Velocity& velocity, Duration hold, bool creep_mode = false);
  /// One control step: `action` in [-1, 1] is clamped and scaled to the operating limits and held for `period`, when
  /// the wait is done. `commanded()` then tells what was executed. Throws as `set_velocity`.
  WaitHandle execute_action(const std::array<double, 3>& action, Duration period, bool creep_mode = false);
  /// Ends a motion as `cancelled` and brings the robot to a stand-still. Always allowed.
  void stop();
  /// Begins a motion, which ends when it has arrived and stands, is proved impossible, makes no progress any more or
  /// has no battery left, and at `timeout` where one is given. Throws ContractError on a goal that is not finite,
  /// EmergencyStopError, SafetyError while another motion owns the robot, HardwareError for an exploration without a
  /// lidar.
  MotionHandle start(const nav::Goal& goal, std::optional<Duration> timeout = {});
  /// Begins a motion that a source steers in place of the navigator, such as a learned policy. It ends as that decides,
  /// once the robot stands; as `policy_error` when the source throws or wants a velocity that is not finite or that the
  /// base cannot drive; as `lost`; and at `timeout`. What it wants is slowed down in zones with a limit and stopped at
  /// the borders of those to keep out of. Throws as `start`.
  MotionHandle drive(VelocitySource source, std::optional<Duration> timeout = {});
  /// A goal that is given in `map`, `odom` or `base`, as it is in `map` now. Throws ContractError on one that is not
  /// finite, and on an unknown frame.
  nav::MoveTo in_map(const nav::MoveTo& goal, std::string_view frame) const;
  /// The motion in progress, or null.
  MotionHandle motion() const;
  /// Where motions may not lead, or only slowly, in `map`: until it is called again, or the world begins anew. Throws
  /// ContractError for what is no polygon, and for a limit that is not positive.
  void set_zones(const std::vector<map::Zone>& zones);
  /// Those that were set.
  const std::vector<map::Zone>& zones() const;
  /// Latches the emergency stop and ends a motion with `estop`. Always allowed.
  void estop();
  /// Allows motions again.
  void release_estop();
  /// Whether the emergency stop is latched.
  bool estopped() const;
  /// Ends a motion with `fault` and keeps the robot still until `connect` is called again.
  void fail(const std::string& what);

  /// Calls `observer` at the end of every tick. Observers may add and remove observers. What an observer throws comes
  /// out of `World::tick` once the tick is complete.
  std::uint64_t observe(Observer observer);
  /// Ends what `observe` began; an unknown `id` does nothing.
  void unobserve(std::uint64_t id);

 private:
  friend class World;
  friend class Motion;
  struct State;
  struct Impl;

  // The two halves of a tick, and beginning anew.
  void act(Time now);
  void sense(Time now);
  void tell(const TickView& view);
  std::shared_ptr<const State> save() const;
  void restore(const State& state);
  void restart();

  std::unique_ptr<Impl> impl_;
};

}  // namespace threewe
