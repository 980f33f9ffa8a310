// Scan track: where the base was of late, and where the newest scan hit something.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "robot/pose_history.hpp"
#include "threewe/core/samples.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe {

/// For localizers that get the robot's pose from outside. Plain data.
class ScanTrack {
 public:
  explicit ScanTrack(const std::optional<LidarSpec>& lidar) : lidar_(lidar) {}

  void add_pose(Time time, const Pose2D& odom_from_base) { track_.add(time, odom_from_base); }
  /// A scan, at poses that were added.
  void add_scan(const LaserScan& scan, Time measured);
  /// As PoseHistory.
  Pose2D at(Time time) const { return track_.at(time); }
  /// Where its beams hit something, in `odom`.
  std::span<const Vec2> obstacles() const { return obstacles_; }

 private:
  std::optional<LidarSpec> lidar_;
  PoseHistory track_;
  std::vector<Vec2> obstacles_;
};

}  // namespace threewe
