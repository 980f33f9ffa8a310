// Detector of motions that make no progress.
#pragma once

#include <limits>
#include <set>
#include <utility>

#include "nav/params.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"

namespace threewe::nav {

/// A motion makes progress while the robot comes to places where it has not been in this motion, or nearer to its goal
/// than ever before. One that has not for its patience and twice as long as the rest of its path takes is stalled: it
/// circles, wavers between two ways, or waits for what does not go away. A bounded place has finitely many places and
/// metres, so every motion ends, and none ends by a clock while it gets on. Plain data.
class ProgressMonitor {
 public:
  /// `speed_limit` [m/s]: of which the robot covers ground at a share, all its turns and stops included.
  ProgressMonitor(double speed_limit, const Params& params)
      : params_(params.progress),
        place_(params.recovery.same_place),
        speed_(params.progress.mean_speed * speed_limit) {}

  /// A motion begins.
  void begin(Time now);
  /// One control period: where the robot is in `map`, and how long [m] its path still is.
  void update(Time now, Vec2 position, double distance_left);
  bool stalled(Time now) const;

 private:
  Params::Progress params_;
  double place_;                                              // [m] places that count as different ones
  double speed_;                                              // [m/s] all in all
  std::set<std::pair<int, int>> visited_;                     // cells
  double nearest_ = std::numeric_limits<double>::infinity();  // [m] the least that was left
  double longest_ = 0.0;                                      // [m] the most that was left since the last progress
  Time last_{};                                               // of progress
};

}  // namespace threewe::nav
