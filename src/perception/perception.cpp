#include "perception/perception.hpp"

#include <algorithm>
#include <cmath>

#include "core/exact.hpp"
#include "hardware/parameters.hpp"

namespace threewe::perception {

PerceptionModel make_perception_model(const RobotProfile& profile, const std::vector<SensorInfo>& sensors) {
  return {profile, sensors, params_for<Params>(profile, "health")};
}

Perception::Perception(const PerceptionModel& model)
    : health_(model.sensors, model.profile, model.params),
      tracker_(model.params.people),
      sonar_returns_(model.params.sonar.arc_spacing),
      sonar_grid_(model.params.sonar, model.params.bump) {}

void Perception::begin(const PerceptionModel& model, Time now) {
  health_.begin(now);
  tracker_ = PeopleTracker(model.params.people);
  people_.clear();
  sonar_returns_ = SonarReturns(model.params.sonar.arc_spacing);
  obstacles_.clear();
}

bool Perception::examine(const PerceptionModel& model, const Sample& sample) {
  return health_.examine(sample, model.sensors, model.profile);
}

void Perception::update(const PerceptionModel& model, const Period& period) {
  health_.judge(period.now, period.commanded, period.pose);
  for (const Sample* sample : period.samples) {
    if (model.profile.lidar) {
      update_sonar_beside_lidar(model, period, *sample);
      track_people(model, period, *sample);
    } else {
      update_sonar_and_bumps(model, period, *sample);
    }
  }
  if (model.profile.lidar) join_obstacles(model, period);
  people_ = tracker_.people(period.now);
}

std::span<const Vec2> Perception::obstacles(const PerceptionModel& model, std::span<const Vec2> hits) const {
  return model.profile.lidar && obstacles_.empty() ? hits : obstacles_;
}

// Beside a lidar echoes count only where they come from what no beam has met: too low, or of glass. The arcs of all
// others would close doors that the lidar sees open.
void Perception::update_sonar_beside_lidar(const PerceptionModel& model, const Period& period, const Sample& sample) {
  const auto* echo = std::get_if<RangeData>(&sample.data);
  if (echo == nullptr || period.hits.empty()) return;
  const SensorInfo& sensor = model.sensors[sample.sensor];
  const Pose2D odom_from_sensor = period.pose.odom_from_base_ago(sample.received - sample.measured) *
                                  model.profile.base_from_sensor(sensor.type, sensor.name);
  const auto seen = transformed(inverse(odom_from_sensor), period.hits);
  const bool explained = std::ranges::any_of(seen, [&](Vec2 p) {
    return norm(p) < echo->range + model.params.sonar.explained &&
           std::abs(exact::atan2(p.y, p.x)) < 0.5 * echo->field_of_view + model.params.sonar.explained_bearing;
  });
  sonar_grid_.update(*echo, period.pose.map_from_odom * odom_from_sensor, explained);
}

void Perception::join_obstacles(const PerceptionModel& model, const Period& period) {
  obstacles_.clear();
  const auto remembered = sonar_grid_.occupied_near(period.pose.map_from_base().position(), model.params.sonar.far);
  if (remembered.empty()) return;
  obstacles_ = transformed(inverse(period.pose.map_from_odom), remembered);
  obstacles_.insert(obstacles_.end(), period.hits.begin(), period.hits.end());
}

// Without a lidar: echoes and bumps, remembered where the robot was as it noticed them.
void Perception::update_sonar_and_bumps(const PerceptionModel& model, const Period& period, const Sample& sample) {
  const Pose2D odom_from_base = period.pose.odom_from_base_ago(sample.received - sample.measured);
  const Pose2D map_from_base = period.pose.map_from_odom * odom_from_base;

  if (const auto* echo = std::get_if<RangeData>(&sample.data)) {
    const SensorInfo& sensor = model.sensors[sample.sensor];
    const Pose2D base_from_sensor = model.profile.base_from_sensor(sensor.type, sensor.name);
    sonar_returns_.update(sample.sensor, *echo, odom_from_base * base_from_sensor);
    sonar_grid_.update(*echo, map_from_base * base_from_sensor);
  } else if (const auto* imu = std::get_if<IMUData>(&sample.data)) {
    const Vec2 push{imu->linear_acceleration[0], imu->linear_acceleration[1]};
    if (!sonar_grid_.detect_bump(push, model.profile.body.footprint, map_from_base)) return;
  } else {
    return;
  }
  const auto remembered = sonar_grid_.occupied_near(map_from_base.position(), model.params.sonar.near);
  obstacles_ = transformed(inverse(period.pose.map_from_odom), remembered);
  const auto received = sonar_returns_.points_in_odom();
  obstacles_.insert(obstacles_.end(), received.begin(), received.end());
}

// Where the robot was as the lidar turned follows from how it moves now.
void Perception::track_people(const PerceptionModel& model, const Period& period, const Sample& sample) {
  const auto* scan = std::get_if<LaserScan>(&sample.data);
  if (scan == nullptr) return;
  const Time first = sample.measured;
  const Time last = first + from_seconds(scan->time_increment * static_cast<double>(scan->ranges.size()));
  const auto [began, ended] = std::minmax(first, last);
  const Pose2D base_from_lidar = model.profile.lidar->base_from_lidar;
  tracker_.update(*scan, began, ended, period.pose.odom_from_base_ago(sample.received - began) * base_from_lidar,
                  period.pose.odom_from_base_ago(sample.received - ended) * base_from_lidar);
}

}  // namespace threewe::perception
