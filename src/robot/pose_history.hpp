// Odometry poses of the last ticks: where the base was as a sample was measured.
#pragma once

#include <vector>

#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"

namespace threewe {

/// Plain data.
class PoseHistory {
 public:
  /// Nothing is known yet.
  void clear() { track_.clear(); }
  /// The pose at a time; an earlier or equal one than the newest is left out.
  void add(Time time, const Pose2D& odom_from_base);
  /// Exact at a time that was added, evenly in between, and no older than the oldest. Of at least one.
  Pose2D at(Time time) const;

 private:
  struct Point {
    Time time{};
    Pose2D odom_from_base;
  };
  std::vector<Point> track_;  // oldest first
};

}  // namespace threewe
