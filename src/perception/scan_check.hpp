// Detector of noisy and biased scans, against those before.
#pragma once

#include <vector>

#include "perception/params.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/samples.hpp"
#include "threewe/perception/percepts.hpp"

namespace threewe::perception {

/// How two scans differ.
struct Shift {
  double metres = 0.0;  ///< by which ranges became longer: the median
  double share = 0.0;   ///< of beams that agree on it
};
/// The shift between two scans on which most beams agree, while the lidar turned by about `turned` [rad] and did not
/// move far.
Shift shift_between(const LaserScan& before, const LaserScan& scan, double turned, const Params::Scan& params = {});

/// Compares each scan with those that were in order.
class ScanCheck {
 public:
  ScanCheck() = default;
  /// `sigma`: standard deviation of ranges by the data sheet [m].
  explicit ScanCheck(double sigma, const Params::Scan& params = {}) : params_(params), least_noise_(sigma) {}
  /// `at`: where the robot is by its wheels.
  SensorFault check(Time measured, const LaserScan& scan, const Pose2D& at);

 private:
  /// A scan, and what is known about it.
  struct View {
    Time stamp{};
    LaserScan scan;
    Pose2D at;
  };
  void judge_shift(const View& view);

  Params::Scan params_;
  double least_noise_ = 0.0;  // [m] what is usual at least
  double usual_noise_ = 0.0;  // [m] 0 before the first scan that tells
  View reference_;            // the newest that was in order
  View before_;               // the newest that was not noisy
  double shift_ = 0.0;        // [m] since the reference
};

}  // namespace threewe::perception
