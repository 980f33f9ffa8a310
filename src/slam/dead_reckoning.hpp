// Dead reckoning by wheels and gyro.
#pragma once

#include <array>
#include <cstddef>

#include "slam/params.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/samples.hpp"
#include "threewe/core/time.hpp"

namespace threewe::slam {

/// Systematic errors of the sensors, as far as they are known.
struct Calibration {
  double gyro_bias = 0.0;      ///< [rad/s], true rate = measured - bias
  double forward_scale = 1.0;  ///< true motion = measured * scale
  double lateral_scale = 1.0;
  double range_bias = 0.0;  ///< [m], true range = measured - bias
  friend bool operator==(const Calibration&, const Calibration&) = default;
};

/// The robot at the stamp of one odometry sample, and how it came there from the sample before.
struct TrackPoint {
  Time stamp{};
  Pose2D odom_from_base;
  Velocity velocity;      ///< body frame, calibrated
  Vec2 step;              ///< [m] moved, in the body frame half way through the turn
  double turn = 0.0;      ///< [rad] turned
  double measured = 0.0;  ///< [rad] the same with the gyro's bias in it
  double rolled = 0.0;    ///< [rad] turned as the wheels say
  double seconds = 0.0;   ///< [s] since the sample before
  bool by_gyro = false;   ///< the turn is the gyro's, not the wheels'
  int standing = 0;       ///< for so many samples the wheels have not turned
};

/// What wheels and gyro measured between two times.
struct MotionSummary {
  double measured = 0.0;       ///< [rad] turned, with the gyro's bias in it, whatever it was taken for meanwhile
  double seconds = 0.0;        ///< of the samples in between
  bool at_rest = false;        ///< the turn is the gyro's, and the wheels stood all the while
  double doubtful_way = 0.0;   ///< [m] that was guessed, where odometry was silent
  double doubtful_turn = 0.0;  ///< [rad] likewise, and by which wheels and gyro differ more than they should
};

/// Integrates wheel translation and gyro rotation into the `odom` frame, which never jumps, and remembers the last
/// second. Heading comes from the wheels while there is no gyro.
class DeadReckoning {
 public:
  /// `scans_follow`: where odometry falls silent for long, scans tell where the robot goes, and what wheels and gyro
  /// tell of that time afterwards is left out.
  explicit DeadReckoning(const Calibration& calibration, bool scans_follow = false,
                         const Params::DeadReckoning& params = {})
      : params_(params), calibration_(calibration), scans_follow_(scans_follow) {}

  void add_gyro(Time stamp, double rate);
  void add_odometry(Time stamp, const Odometry& odometry);

  const Calibration& calibration() const { return calibration_; }
  /// Takes effect from now on: what was integrated stays as it is.
  void calibrate(const Calibration& calibration) { calibration_ = calibration; }

  bool empty() const { return count_ == 0; }
  /// How many points are remembered; `point(0)` is the newest.
  std::size_t size() const { return count_ < kCapacity ? count_ : kCapacity; }
  const TrackPoint& point(std::size_t age) const { return points_[(count_ - 1 - age) % kCapacity]; }
  /// The newest sample.
  const Odometry& odometry() const { return wheels_; }
  /// odom_from_base at a time: interpolated, extrapolated from the newest point by at most 0.3 s, held before the
  /// oldest. Identity while there is no point.
  Pose2D at(Time stamp) const;
  /// What has been measured of the time after `from`, up to `to`.
  MotionSummary between(Time from, Time to) const;
  /// The wheels have turned since the beginning.
  bool has_rolled() const { return rolled_; }
  /// The wheels have been at rest for some time.
  bool stands() const;

 private:
  double gyro_heading(Time stamp) const;

  static constexpr std::size_t kCapacity = 64;
  Params::DeadReckoning params_;
  Calibration calibration_;
  bool scans_follow_ = false;
  std::array<TrackPoint, kCapacity> points_{};
  std::size_t count_ = 0;
  Odometry wheels_;  // the newest odometry sample
  bool rolled_ = false;
  bool has_gyro_ = false;
  Time gyro_stamp_{};
  double gyro_rate_ = 0.0;     // as measured
  double heading_ = 0.0;       // integral of what the gyro measured up to gyro_stamp_
  double heading_used_ = 0.0;  // the same at the newest point
};

}  // namespace threewe::slam
