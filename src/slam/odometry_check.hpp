// Odometry check: registers the scans of a log, of which neither lidar nor odometry is trusted blindly.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "slam/front_end.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/samples.hpp"

namespace threewe::slam {

/// How a scan was registered.
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
  bool odometry_scaled = false;   ///< lately odometry moved more or less than scans did, by one factor
};

/// Where a step of the odometry does not lead to where the scan fits, the motion so far is tried in its place, each on
/// a copy of the front end, and the scan decides.
class OdometryCheck {
 public:
  explicit OdometryCheck(SharedParams params = reference_params()) : params_(std::move(params)) {}

  /// One scan, measured at `stamp`, later than the last, while the robot's odometry was `odom_from_base`; empty where
  /// there is none: then scans alone tell the motion, as long as they overlap a lot. `map`: null where nothing was
  /// mapped. Afterwards `front` stands at the scan.
  Registration add(FrontEnd& front, const map::LogOddsMap* map, Time stamp, const LaserScan& scan, double range_max,
                   const std::optional<Pose2D>& odom_from_base);

 private:
  /// A step of the robot since the scan before.
  struct Motion {
    Pose2D step;
    double position_sigma = 0.0;  // [m] by which it may be off, beyond what odometry is
    double heading_sigma = 0.0;   // [rad]
  };
  /// Distances [m] of late, which fade as the robot goes on: what odometry stated, and what scans measured of it.
  struct Driven {
    double stated = 0.0;
    double measured = 0.0;
    double ratio() const { return measured / stated; }
  };
  /// A scan and what it is matched with.
  struct View {
    const map::LogOddsMap* map;
    Time stamp;
    const LaserScan& scan;
    double range_max;
  };

  bool repeats(const LaserScan& scan, const Pose2D& step, Registration& seen);
  bool register_scan(FrontEnd& front, const View& view, const std::optional<Pose2D>& step, Registration& seen);
  bool is_better(const FrontEnd& by_odometry, const FrontEnd& steady, bool impossible) const;
  Pose2D rescaled(const Pose2D& step) const;
  bool is_scaled() const;
  void compare(const FrontEnd& front, const Pose2D& before, const std::optional<Pose2D>& step);
  Motion steady_motion(const FrontEnd& front, Time stamp) const;
  void follow(FrontEnd& front, const View& view, const Motion& motion) const;
  bool has_moved(const FrontEnd& front, const map::LogOddsMap& map) const;
  void judge(const FrontEnd& front, bool related, Registration& seen);

  SharedParams params_;
  std::optional<Pose2D> raw_;      // the newest odometry, as it came
  bool odometry_stopped_ = false;  // since the robot was seen to move without it
  Pose2D moved_;                   // from the scan before to the newest, as registered ...
  double moved_seconds_ = 0.0;     // ... in this time
  Driven driven_;                  // where scans left no direction open
  Pose2D stated_;                  // by odometry, since they grew ...
  Pose2D measured_;                // ... as registered
  std::vector<float> ranges_;      // of the newest scan
  Pose2D frozen_step_;             // by odometry, since the first of equal scans
  int misfits_ = 0;                // scans in a row that are not where they should be
  double usual_agreement_ = 0.0;   // of scans with the map, lately
};

}  // namespace threewe::slam
