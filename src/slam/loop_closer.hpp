// Loop closure detection: search for the robot in a submap, and verification.
#pragma once

#include <optional>
#include <span>

#include "map/log_odds_map.hpp"
#include "slam/branch_and_bound_matcher.hpp"
#include "slam/params.hpp"
#include "slam/pose_filter.hpp"
#include "threewe/core/pose.hpp"

namespace threewe::slam {

/// Where a robot is thought to be in a map.
struct PoseBelief {
  Pose2D pose;
  Matrix3 covariance = Matrix3::Zero();  ///< of (x, y, theta) along the map's axes [m^2, rad^2]
};

/// A place found again. Both `covariance`s say how far off the pose may be by the scans alone.
struct LoopMatch {
  Pose2D map_from_base;
  Matrix3 covariance = Matrix3::Zero();
  double score = 0.0;      ///< of the search, at most 1
  double agreement = 0.0;  ///< share of the hits in known space that lie on a surface
};

/// Finds a robot in a piece of a map that it left some time ago, or in a given map, and refuses whatever might be
/// wrong: a wrong closure bends the whole map, a missed one is made up for a few metres later.
class LoopCloser {
 public:
  /// `map`: finished; nothing is added to it any more.
  explicit LoopCloser(map::LogOddsMap map, SharedParams params = reference_params());

  /// Where the robot is, if that is beyond doubt. `view`: beams in the base frame, of one scan or of `scans` scans
  /// along the last metres, as they lie to one another.
  std::optional<LoopMatch> find(std::span<const map::Beam> view, int scans, const PoseBelief& belief,
                                double range_bias) const;

  std::size_t bytes() const;

 private:
  SharedParams params_;
  map::LogOddsMap map_;
  BranchAndBoundMatcher search_;
};

}  // namespace threewe::slam
