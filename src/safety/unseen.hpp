// Unobserved sectors as obstacle points for the collision monitor: unknown is not free.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "safety/gate.hpp"
#include "safety/params.hpp"
#include "threewe/core/footprint.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe::safety {

/// What never changes while a robot runs.
struct SightModel {
  Footprint footprint;
  double thin = 0.0;       ///< [m] what is thinner may stand between two beams: thinner legs are rare
  double step = 0.0;       ///< [m] along a beam, from point to point
  double margin = 0.0;     ///< [m] around the footprint, of which the gate takes care
  double range_min = 0.0;  ///< [m] of the lidar
  double reach = 0.0;      ///< [m] from the lidar: what is farther concerns the gate with a later scan
  double near_gap = 0.0;   ///< [m] both beams beside a gap are shorter: what is in it is nearer than the lidar measures
  Duration memory{};       ///< what was seen to be free longer ago than this is unknown again
  std::size_t scans = 0;   ///< that may come in this time
};
SightModel make_sight_model(const RobotProfile& profile, const GateModel& gate);

/// When a scan ended, and where the lidar was as it measured the first of its beams and the last, in `odom`. Beam i
/// points along `i * 2 pi / beams - pi`.
struct ScanTurn {
  Time end{};
  Pose2D odom_from_lidar_at_first;
  Pose2D odom_from_lidar_at_last;
};

/// A scan that is remembered.
struct PlacedScan {
  ScanTurn turn;
  std::vector<float> ranges;  ///< [m]; no return = range_max, invalid = 0
};

/// The scans of the last moments, and where the newest is blind. Plain data.
///
/// A beam without return has seen that its way is free; an invalid one has seen nothing. Where several of those are
/// side by side, only what an earlier scan saw to be free, within the model's `memory`, counts as free; the first point
/// along each of them that none did stands for whatever may be there. A single beam that drops out is no gap: the
/// beams beside it pass as near to what is there as they do anywhere.
class Sight {
 public:
  /// Nothing has been seen yet.
  void forget();
  /// The newest scan; the robot was at `odom_from_base` as it ended.
  void add(const SightModel& model, const ScanTurn& turn, std::span<const float> ranges, const Pose2D& odom_from_base);
  /// Where something may be that no beam has seen, in `odom` [m].
  std::span<const Vec2> unseen() const { return unseen_; }
  /// The newest scan but so many; null where there were not that many, or they are forgotten.
  const PlacedScan* scan_before(std::size_t count) const;

 private:
  std::vector<double> still_unseen(double thin, const PlacedScan& scan) const;

  std::vector<PlacedScan> scans_;  // a ring; those within the memory count
  std::size_t newest_ = 0;
  std::vector<Vec2> unseen_;
};

}  // namespace threewe::safety
