// Range-noise estimator: standard deviation of a lidar's ranges, from its scans alone.
#pragma once

#include "threewe/core/samples.hpp"

namespace threewe::slam {

/// Deviation of one range [m] by a scan alone; 0 where too few beams tell.
///
/// Three beams side by side mostly hit one flat surface: by how much the middle one is off the line through its
/// neighbours tells of the scatter, and nothing else does, neither the robot's place nor its motion nor a bias. Of all
/// threes of a scan the median counts, so that edges and clutter do little.
double range_noise_of(const LaserScan& scan);

/// The same over the last few seconds. A lidar may be worse than its maker says, and get worse on the way.
class RangeNoiseEstimator {
 public:
  /// `expected`: deviation of one range [m] by its data sheet.
  explicit RangeNoiseEstimator(double expected) : sigma_(expected) {}

  void add(const LaserScan& scan);
  /// Deviation of one range [m], of the scans of the last few seconds.
  double sigma() const { return sigma_; }

 private:
  double sigma_;
  int scans_ = 0;
};

}  // namespace threewe::slam
