// Simulation model: what never changes while a simulation runs: the scene, the robots in it, and all that follows.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "models/battery.hpp"
#include "models/drive.hpp"
#include "models/lidar.hpp"
#include "models/odometry.hpp"
#include "models/traction.hpp"
#include "sim/contact.hpp"
#include "sim/ray_caster.hpp"
#include "sim/renderer.hpp"
#include "sim/shape_index.hpp"
#include "threewe/core/time.hpp"
#include "threewe/hardware/profile.hpp"
#include "threewe/scene/scene.hpp"

namespace threewe::sim {

/// One step of physics; two make a control period.
inline constexpr Duration kStep = 10ms;
/// The longest command latency that a state has room for [steps].
inline constexpr int kMaxLatencySteps = 16;
/// The most lidar points a turn that a state has room for.
inline constexpr int kMaxLidarPoints = 512;

/// One robot of a world. Periods and latencies are counted in steps.
struct RobotModel {
  RobotProfile profile;
  models::Drive drive;
  models::TractionModel traction_model;
  models::Battery battery;
  models::Odometer odometer;
  std::vector<Vec2> wheels;  ///< where the driven ones touch the floor, in the base frame
  RigidBody body;
  std::vector<scene::Solid> solids;             ///< all that stands as high as the robot reaches
  std::shared_ptr<const ShapeIndex> obstacles;  ///< the same, as outlines
  int command_latency = 0;
  int imu_period = 0;
  int odometry_period = 0;
  int battery_period = 0;
  int turn = 0;                 ///< of the lidar
  int ultrasonic_interval = 0;  ///< from ping to ping
  models::ScanPattern pattern;
  std::shared_ptr<const RayCaster> caster;    ///< null without a lidar
  std::shared_ptr<const ShapeIndex> audible;  ///< what ultrasonic sensors can hear; null without any
};

/// A scene and the robots that share it. Const once made; every world and every thread may share one.
struct Model {
  std::shared_ptr<const scene::Scene> scene;
  std::vector<RobotModel> robots;

  /// What draws the scene: made when a picture is first looked at. Any thread may ask.
  const Renderer& renderer() const;

 private:
  mutable std::once_flag asked_;
  mutable std::optional<Renderer> renderer_;
};

/// Throws ConfigError where a profile cannot be simulated: a period that is no whole number of steps, or a lidar whose
/// points do not divide evenly among the steps of a turn.
std::shared_ptr<const Model> make_model(std::shared_ptr<const scene::Scene> scene,
                                        const std::vector<RobotProfile>& robots);

}  // namespace threewe::sim
