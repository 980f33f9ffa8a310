// Where the robot is by its wheels and by what it has just passed: drifts slowly, never jumps.
#pragma once

#include <vector>

#include "slam/dead_reckoning.hpp"
#include "slam/pose_filter.hpp"
#include "slam/scan_matcher.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/samples.hpp"
#include "threewe/map/log_odds_map.hpp"

namespace threewe::slam {

/// Fits each scan to a map of the last metres, in the frame `local`, which begins at the first scan. What was mapped
/// longer ago is forgotten: whoever closes loops finds it in the scans that `Slam` keeps.
class ScanOdometry {
 public:
  struct Settings {
    SensorModel sensors;
    double range_max = 0.0;   ///< [m] what is farther is left out
    double range_bias = 0.0;  ///< [m] by which all ranges are too long, as far as is known before
  };
  explicit ScanOdometry(const Settings& settings);

  /// One scan, measured while the robot's odometry was `odom_from_base` at `stamp`, later than the last. Returns
  /// local_from_base.
  Pose2D add(Time stamp, const LaserScan& scan, const Pose2D& odom_from_base);

  /// Of local_from_base: (x, y, theta) along the axes of `local` [m^2, rad^2].
  Matrix3 covariance() const { return filter_.covariance().topLeftCorner<3, 3>(); }
  /// The beams of the newest scan, in the base frame.
  const std::vector<map::Beam>& beams() const { return beams_; }
  /// Whether they went into the map: the robot has moved, or turned, or seen little so far.
  bool mapped() const { return mapped_; }
  /// By how much all ranges are too long, as far as is known [m].
  double range_bias() const { return track_.calibration().range_bias; }

 private:
  void predict(Time stamp, const Pose2D& odom_from_base);
  void look(Time stamp, const LaserScan& scan);
  void correct();
  void shift(const Vector7& by, const Pose2D& from);
  void extend_maps();
  Pose2D local_from_base() const { return local_from_odom_ * track_.point(0).odom_from_base; }

  /// A piece of the surroundings, in `local`.
  struct Piece {
    map::LogOddsMap map;
    double begun = 0.0;  ///< [m] driven until it was
  };
  const map::LogOddsMap& reference() const { return pieces_.front().map; }

  Settings settings_;
  DeadReckoning track_;
  PoseFilter filter_;
  Odometry odometry_;  // the newest
  Pose2D local_from_odom_;
  std::vector<map::Beam> beams_;
  std::vector<Piece> pieces_;  // the older one is matched with, the younger will take its place
  double driven_ = 0.0;        // [m] since the first scan
  Pose2D mapped_from_;         // local_from_base when the maps last took a scan
  int misfits_ = 0;            // scans in a row that are not where they should be
  bool mapped_ = false;
};

}  // namespace threewe::slam
