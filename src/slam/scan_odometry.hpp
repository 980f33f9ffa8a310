// Scan odometry: pose by odometry and by matching with the last metres. Drifts slowly, never jumps.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "map/log_odds_map.hpp"
#include "slam/dead_reckoning.hpp"
#include "slam/pose_filter.hpp"
#include "slam/scan_matcher.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/samples.hpp"

namespace threewe::slam {

/// How the newest scan was registered.
struct Registration {
  enum class Scan : std::uint8_t {
    fits,      ///< with what was mapped before, or so little is known here that nothing contradicts it
    repeated,  ///< the same as the one before, to the bit: no measurement
    misfit,    ///< with nothing around where the robot may be: it is no part of the map
    lost,      ///< misfits in a row: nothing relates this scan to those before, and the local map begins anew
  };
  Scan scan = Scan::fits;
  bool frozen = false;            ///< repeated, though odometry has moved since the first of them
  bool odometry_jumped = false;   ///< scans contradict the step of the odometry, which was left out
  bool odometry_stopped = false;  ///< scans move, odometry does not
};

/// Fits each scan to a map of the last metres, in the frame `local`, which begins at the first scan. What was mapped
/// longer ago is forgotten: whoever closes loops finds it in the scans that `Slam` keeps. Where a step of the odometry
/// does not lead to where the scan fits, the motion so far is tried in its place, and the scan decides.
class ScanOdometry {
 public:
  struct Settings {
    SensorModel sensors;
    double range_max = 0.0;   ///< [m] what is farther is left out
    double range_bias = 0.0;  ///< [m] by which all ranges are too long, as far as is known before
  };
  explicit ScanOdometry(const Settings& settings);

  /// One scan, measured at `stamp`, later than the last, while the robot's odometry was `odom_from_base`; empty where
  /// there is none: then scans alone tell the motion, as long as they overlap a lot. Returns local_from_base.
  Pose2D add(Time stamp, const LaserScan& scan, const std::optional<Pose2D>& odom_from_base);

  /// How the newest scan was registered.
  const Registration& registration() const { return registration_; }
  /// Of local_from_base: (x, y, theta) along the axes of `local` [m^2, rad^2].
  Matrix3 covariance() const { return belief_.filter.covariance().topLeftCorner<3, 3>(); }
  /// The beams of the newest scan, in the base frame; none where it is no part of the map.
  const std::vector<map::Beam>& beams() const { return beams_; }
  /// By how much all ranges are too long, as far as is known [m].
  double range_bias() const { return belief_.track.calibration().range_bias; }

 private:
  /// Where the robot is by one account of its motion, and how well the newest scan fits there.
  struct Belief {
    explicit Belief(const Settings& settings)
        : track(Calibration{.range_bias = settings.range_bias}), filter(settings.sensors) {}

    Pose2D local_from_base() const { return local_from_odom * track.point(0).odom_from_base; }

    Odometry odometry;  // the steps that were believed, one after the other
    DeadReckoning track;
    PoseFilter filter;
    Pose2D local_from_odom;
    Match match;
    bool contradicted = false;  // by the map, where the scan was found
  };
  /// A step of the robot since the scan before.
  struct Motion {
    Pose2D step;
    double position_sigma = 0.0;  ///< [m] by which it may be off, beyond what odometry is
    double heading_sigma = 0.0;   ///< [rad]
  };

  bool repeats(const LaserScan& scan, const std::optional<Pose2D>& step);
  bool register_scan(Time stamp, const LaserScan& scan, const std::optional<Pose2D>& step);
  void decide(Time stamp, const LaserScan& scan, const Belief& before, const Motion& steady, bool impossible);
  Motion steady_motion(Time stamp) const;
  void follow(Time stamp, const LaserScan& scan, const Motion& motion);
  void predict(Time stamp, const Motion& motion);
  void look(Time stamp, const LaserScan& scan);
  void correct(const Motion& motion);
  void shift(const Vector7& by, const Pose2D& from);
  bool has_moved() const;
  bool is_confirmed(const Match& match) const;
  bool is_contradicted(const Match& match) const;
  bool crosses_walls() const;
  void judge(bool related);
  void extend_maps();

  /// A piece of the surroundings, in `local`.
  struct Piece {
    map::LogOddsMap map;
    double begun = 0.0;  ///< [m] driven until it was
  };
  const map::LogOddsMap& reference() const { return pieces_.front().map; }

  Settings settings_;
  Belief belief_;
  Registration registration_;
  std::optional<Pose2D> raw_;      // the newest odometry, as it came
  bool odometry_stopped_ = false;  // since the robot was seen to move without it
  Pose2D moved_;                   // from the scan before to the newest, as registered ...
  double moved_seconds_ = 0.0;     // ... in this time
  std::vector<float> ranges_;      // of the newest scan
  Pose2D frozen_step_;             // by odometry, since the first of equal scans
  std::vector<map::Beam> beams_;
  std::vector<Piece> pieces_;  // the older one is matched with, the younger will take its place
  double driven_ = 0.0;        // [m] since the first scan
  Pose2D mapped_from_;         // local_from_base when the maps last took a scan
  double usual_ = 0.0;         // agreement of scans with the map lately
  int misfits_ = 0;            // scans in a row that are not where they should be
};

}  // namespace threewe::slam
