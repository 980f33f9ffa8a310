// Scan-to-map front end: predicts the pose by wheels and gyro, matches each scan with a map, updates the estimate.
#pragma once

#include <cstdint>
#include <vector>

#include "map/log_odds_map.hpp"
#include "slam/dead_reckoning.hpp"
#include "slam/params.hpp"
#include "slam/pose_filter.hpp"
#include "slam/range_noise_estimator.hpp"
#include "slam/scan_matcher.hpp"
#include "slam/sensor_model.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/samples.hpp"

namespace threewe::slam {

/// When the last beam of a scan was measured.
Time end_of(Time measured, const LaserScan& scan);

/// How far off the prediction may be, beyond what the filter says.
struct Doubt {
  double position = 0.0;  ///< [m] standard deviation of a motion that was guessed
  double heading = 0.0;   ///< [rad] likewise
  bool lost = false;      ///< the pose is no more than where the robot was last believed to be
};

/// What robots and mapped logs have in common. The map belongs to the caller: the whole map of a robot, the last metres
/// of a log. Gyro and odometry are optional, and scans may be taken at once or beam by beam. The track in `odom` never
/// jumps; matches move `map_from_odom` and calibrate the sensors. Plain data: a copy is another account of the same
/// motion, and goes on with the same bits.
class FrontEnd {
 public:
  explicit FrontEnd(const SensorModel& sensors, SharedParams params = reference_params(),
                    const Pose2D& map_from_odom = {}, double range_bias = 0.0);

  void add_gyro(Time stamp, double rate) { track_.add_gyro(stamp, rate); }
  void add_odometry(Time stamp, const Odometry& odometry) { track_.add_odometry(stamp, odometry); }
  /// Takes the beams of a scan, whose beam 0 was measured at `measured`, as if all were measured at `stamp`. What is
  /// `range_max` [m] away or farther counts as no return.
  void add_scan(Time measured, const LaserScan& scan, Time stamp, double range_max);
  /// Carries the belief to a time, by wheels and gyro.
  void predict_to(Time stamp);
  /// Where the newest scan fits in a map: near the prediction; where it does not fit there or the heading is unsure,
  /// all poses around are tried. Changes nothing but the filter, which learns that the robot may be elsewhere.
  const Match& match(const map::LogOddsMap& map, const Doubt& doubt = {});
  /// Where the newest scan fits around the prediction, when nothing but the scan counts.
  Match match_alone(const map::LogOddsMap& map) const;
  /// Takes the newest match for true; not to be called while the robot holds its pose.
  void update();

  /// What is known of the pose, anew.
  void set_pose(const Pose2D& map_from_base, double position_sigma, double heading_sigma);
  /// The map has been drawn anew: what was there is here now.
  void move_map(const Pose2D& new_from_old, double position_sigma, double heading_sigma);
  /// Whether a map that was changed `version` times needs the newest scan.
  bool is_due(std::uint64_t version) const;
  /// The map has taken the newest scan.
  void set_mapped();

  const Params& params() const { return *params_; }
  const DeadReckoning& track() const { return track_; }
  const Pose2D& map_from_odom() const { return map_from_odom_; }
  /// At the time of the prediction.
  Pose2D map_from_base() const { return map_from_odom_ * track_.at(stamp_); }
  Time stamp() const { return stamp_; }
  /// Of pose and sensors at the time of the prediction, and now: with what odometry has added since.
  const Matrix7& covariance() const { return filter_.covariance(); }
  Matrix7 newest_covariance() const;
  /// Of the newest scan: its beams in the base frame, its hits, and its match.
  const std::vector<map::Beam>& beams() const { return beams_; }
  std::ptrdiff_t hits() const;
  const Match& newest_match() const { return match_; }
  /// Whether it fits where it was matched, or so little is known there that nothing contradicts it.
  bool fits() const { return fits_; }
  /// Whether the robot rests, and the scan says no more than that it still does.
  bool holds() const { return holds_; }
  /// Whether it fits there so well that nothing but the scan is needed to believe it.
  bool is_confirmed(const Match& match) const;
  /// By how much all ranges are too long, as far as is known [m].
  double range_bias() const { return track_.calibration().range_bias; }
  /// Standard deviation of the lidar's ranges [m], as measured.
  double range_noise() const { return range_noise_.sigma(); }

 private:
  void judge_lidar(const LaserScan& scan);
  void predict(PoseFilter& filter, Time until) const;
  double gyro_bias_error(const MotionSummary& motion) const;
  bool is_gyro_bias(const MotionSummary& motion) const;
  void learn_gyro_bias(const MotionSummary& motion);
  bool knows_more_than_scan() const;
  const Match& match_at_rest(const map::LogOddsMap& map, const Doubt& doubt);
  const Match& match_near(const map::LogOddsMap& map, const Pose2D& start, const Doubt& doubt, bool moved);
  Match match_at(const map::LogOddsMap& map, const Pose2D& start, const PoseFilter& filter) const;
  void search(const map::LogOddsMap& map, const Doubt& doubt, bool poor);
  SearchWindow window(const Doubt& doubt) const;
  bool may_be_elsewhere(const Doubt& doubt) const;
  bool is_contradicted(const map::LogOddsMap& map, const Doubt& doubt) const;
  bool crosses_walls(const map::LogOddsMap& map) const;
  void shift(const Vector7& by, const Pose2D& from);

  SharedParams params_;
  SensorModel sensors_;
  DeadReckoning track_;
  RangeNoiseEstimator range_noise_;
  double noisier_ = 1.0;  // times the noise of its data sheet the lidar is taken to have
  PoseFilter filter_;
  Time stamp_ = Time::min();  // that the filter stands at
  Pose2D map_from_odom_;
  double doubtful_turn_ = 0.0;  // [rad] since the prediction before
  bool rests_ = false;          // wheels and gyro have stood since then

  std::vector<map::Beam> beams_;
  Match match_;
  bool fits_ = true;
  bool holds_ = false;
  double agreement_at_rest_ = 0.0;  // about the best of late

  Pose2D mapped_at_;  // map_from_base when the map last took a scan
  Time mapped_stamp_{};
};

}  // namespace threewe::slam
