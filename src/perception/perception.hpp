// Perception of one robot: sensor faults, obstacle points, sonar grid and people, from its own samples.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "perception/health_monitor.hpp"
#include "perception/params.hpp"
#include "perception/people_tracker.hpp"
#include "perception/sonar_grid.hpp"
#include "perception/sonar_returns.hpp"
#include "threewe/core/samples.hpp"
#include "threewe/hardware/profile.hpp"
#include "threewe/slam/localizer.hpp"

namespace threewe::perception {

/// What never changes while a robot runs.
struct PerceptionModel {
  RobotProfile profile;
  std::vector<SensorInfo> sensors;  ///< as `Sample::sensor` counts them
  Params params{};
};
/// Of a robot, with its own parameters.
PerceptionModel make_perception_model(const RobotProfile& profile, const std::vector<SensorInfo>& sensors);

/// What a control period brought.
struct Period {
  Time now{};                              ///< at its end
  std::span<const Sample* const> samples;  ///< that may be used, in order of arrival
  const slam::PoseEstimate& pose;          ///< after them
  std::span<const Vec2> hits;              ///< of the newest scan, in `odom`: the localizer's `obstacles`
  Velocity commanded;                      ///< to the robot
};

/// What the samples of a robot say of its sensors, of what stands around it and of who walks there. Plain data.
class Perception {
 public:
  explicit Perception(const PerceptionModel& model);

  /// The robot was connected: what was seen before is old. What sonar has found on the way stays in the grid.
  void begin(const PerceptionModel& model, Time now);
  /// One sample, in order of arrival. True when it may be used.
  bool examine(const PerceptionModel& model, const Sample& sample);
  /// The end of a period.
  void update(const PerceptionModel& model, const Period& period);

  const HealthMonitor& health() const { return health_; }
  /// Places of the sensors whose faults have begun or ended since the last call.
  std::vector<std::size_t> take_health_changes() { return health_.take_changes(); }
  /// Where something stands, in `odom`: what the lidar hits and what only sonar tells of; without a lidar, sonar
  /// returns and bumps. `hits` as in Period.
  std::span<const Vec2> obstacles(const PerceptionModel& model, std::span<const Vec2> hits) const;
  /// Who walks around the robot, in `odom`, at the end of the newest period; none without a lidar.
  std::span<const TrackedPerson> people() const { return people_; }
  /// What sonar and bumps tell of the place, in `map`.
  const SonarGrid& sonar_grid() const { return sonar_grid_; }

 private:
  void update_sonar_beside_lidar(const PerceptionModel& model, const Period& period, const Sample& sample);
  void update_sonar_and_bumps(const PerceptionModel& model, const Period& period, const Sample& sample);
  void track_people(const PerceptionModel& model, const Period& period, const Sample& sample);
  void join_obstacles(const PerceptionModel& model, const Period& period);

  HealthMonitor health_;
  PeopleTracker tracker_;
  std::vector<TrackedPerson> people_;  // in `odom`, now
  SonarReturns sonar_returns_;         // of a robot without a lidar
  SonarGrid sonar_grid_;
  std::vector<Vec2> obstacles_;  // in `odom`; with a lidar empty while its hits are all there is
};

}  // namespace threewe::perception
