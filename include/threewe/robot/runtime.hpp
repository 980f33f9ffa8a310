// The mind, the gate and the port of one robot: the only place where they meet.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "threewe/backend/world.hpp"
#include "threewe/nav/navigator.hpp"
#include "threewe/robot/results.hpp"
#include "threewe/robot/world.hpp"
#include "threewe/safety/gate.hpp"
#include "threewe/slam/localizer.hpp"

namespace threewe {

/// A motion in progress.
class Motion : public Wait {
 public:
  const Progress& progress() const { return progress_; }
  /// Ends the motion with `cancelled` and commands zero in the next period. Does nothing once done.
  void cancel();
  /// Throws ContractError before `done()`.
  const MoveResult& result() const;
  ExploreResult explore_result() const;

 private:
  friend class Runtime;
  Runtime* runtime_ = nullptr;
  Progress progress_;
  MoveResult result_;
  double explored_area_ = 0.0;
};
using MotionHandle = std::shared_ptr<Motion>;

/// What an observer sees at the end of every tick. References are valid during the call only.
struct TickView {
  Time now{};
  std::span<const Sample> samples;       ///< that arrived in this tick
  const slam::PoseEstimate& pose;
  const Velocity& requested;             ///< before the gate
  const safety::GateOutput& commanded;   ///< after it
  const Runtime& robot;
};
using Observer = std::function<void(const TickView&)>;

/// One robot. Everything it does passes through here; see `Robot` for the calls that users make.
class Runtime {
 public:
  struct Options {
    std::unique_ptr<slam::Localizer> localizer;  ///< ours by default
    std::unique_ptr<nav::Navigator> navigator;   ///< ours by default
  };
  Runtime(World& world, backend::RobotPort& port, Options options);
  ~Runtime();

  void connect();
  void disconnect();
  bool connected() const;
  const RobotProfile& profile() const;
  const backend::Features& features() const;

  // Readings: what arrived last. They never advance time. HardwareError where the sensor is missing.
  const LaserScan& lidar_scan() const;
  const IMUData& imu() const;
  const Odometry& odometry() const;
  const BatteryState& battery() const;
  const slam::PoseEstimate& pose() const;
  const map::OccupancyGrid& map() const;
  std::span<const Vec2> path() const;

  /// Drives at `velocity` for at most `hold`. Throws ContractError on a velocity that is not finite or that the base
  /// cannot drive, EmergencyStopError while the stop is latched, SafetyError while a motion owns the robot.
  void set_velocity(const Velocity& velocity, Duration hold);
  void stop();
  /// Begins a motion. `timeout` of 0 takes the default. Refuses a second owner with SafetyError.
  MotionHandle start(const nav::Goal& goal, Duration timeout);
  /// Latches the emergency stop.
  void estop();
  void release_estop();
  bool estopped() const;
  /// Ends every motion with `fault` and keeps the robot still until `connect` is called again.
  void fail(const std::string& what);

  std::uint64_t observe(Observer observer);
  void unobserve(std::uint64_t id);

  // The two halves of a tick, called by World.
  void act(Time now);
  void sense(Time now);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace threewe
