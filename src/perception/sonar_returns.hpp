// Sonar returns as obstacle points for the collision monitor.
#pragma once

#include <span>
#include <vector>

#include "threewe/core/pose.hpp"
#include "threewe/core/samples.hpp"

namespace threewe::perception {

/// Where an echo may have come from, in the sensor's frame [m]: the whole arc of the cone at its range, since nobody
/// knows where in the cone the surface is; the arc at `range_min` for a reading that was too near. Nothing without an
/// echo: a surface that glances sound off is not heard, and no point stands for it.
std::vector<Vec2> sonar_arc(const RangeData& echo);

/// The newest arc of each sensor of a robot, in its `odom` frame.
class SonarReturns {
 public:
  /// Takes the place of what this sensor heard before.
  void update(std::size_t sensor, const RangeData& echo, const Pose2D& odom_from_sensor);
  /// All of them, valid until the next call of `update`.
  std::span<const Vec2> points_in_odom() const { return all_; }

 private:
  std::vector<std::vector<Vec2>> arcs_;  // by sensor
  std::vector<Vec2> all_;
};

}  // namespace threewe::perception
