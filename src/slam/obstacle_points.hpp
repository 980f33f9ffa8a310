// Obstacle points: the hits of the newest scan, and earlier ones that are now nearer than the lidar can see.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "map/log_odds_map.hpp"
#include "slam/params.hpp"
#include "threewe/core/pose.hpp"

namespace threewe::slam {

/// In `odom`, so that they stay where they are whatever corrects the pose in the map.
class ObstaclePoints {
 public:
  explicit ObstaclePoints(const Params::Obstacles& params) : params_(params) {}

  /// A scan, its beams in the base frame; `nearest` [m] is the least range that the lidar measures.
  void update(std::span<const map::Beam> beams, double range_bias, const Pose2D& odom_from_base, Vec2 lidar_in_odom,
              double nearest);
  std::span<const Vec2> points() const { return points_; }

 private:
  std::vector<Vec2> what_may_vanish(Vec2 lidar_in_odom, double nearest) const;
  void keep_unseen(const std::vector<Vec2>& nearby);

  Params::Obstacles params_;
  std::vector<Vec2> points_;
  std::size_t seen_ = 0;  // how many of these are hits
};

}  // namespace threewe::slam
