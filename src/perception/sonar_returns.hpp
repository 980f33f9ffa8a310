// Sonar returns as obstacle points for the collision monitor.
#pragma once

#include <span>
#include <vector>

#include "perception/params.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/samples.hpp"

namespace threewe::perception {

/// Where an echo may have come from, in the sensor's frame [m]: the whole arc of the cone at its range, since the
/// surface may be anywhere in the cone; the arc at `range_min` for a reading that was too near. Nothing without an
/// echo: a surface that glances sound off is not detected, and no point stands for it.
/// `spacing` [m]: between two of its points.
std::vector<Vec2> sonar_arc(const RangeData& echo, double spacing = Params::Sonar{}.arc_spacing);

/// The newest arc of each sensor of a robot, in its `odom` frame.
class SonarReturns {
 public:
  explicit SonarReturns(double spacing = Params::Sonar{}.arc_spacing) : spacing_(spacing) {}
  /// Takes the place of this sensor's return before.
  void update(std::size_t sensor, const RangeData& echo, const Pose2D& odom_from_sensor);
  /// All of them, valid until the next call of `update`.
  std::span<const Vec2> points_in_odom() const { return all_; }

 private:
  double spacing_;                       // [m]
  std::vector<std::vector<Vec2>> arcs_;  // by sensor
  std::vector<Vec2> all_;
};

}  // namespace threewe::perception
