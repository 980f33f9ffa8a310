// Where a scan fits a map.
#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

#include "slam/pose_filter.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/map/log_odds_map.hpp"

namespace threewe::slam {

/// A piece of a mapped surface near a point.
struct Surface {
  Vec2 mean;              ///< [m] of the hits around
  Vec2 normal;            ///< unit; of the line through them
  double spread = 0.0;    ///< [m^2] of the hits along the normal
  bool line = false;      ///< false: a spot, known in both directions alike
};

/// The surface at `point`, from the hits in the 3 x 3 cells around it that were seen from the side of `sensor`; empty
/// where there are none.
std::optional<Surface> surface_at(const map::LogOddsMap& map, Vec2 point, Vec2 sensor);

/// The distance [m] of a point from a surface along `direction`, and how it changes with the pose (x, y, theta).
struct Residual {
  double value = 0.0;
  Vector3 jacobian = Vector3::Zero();
};
Residual residual(const Surface& surface, Vec2 direction, const Pose2D& pose, Vec2 point_in_base);

/// Where a scan fits best.
struct Match {
  Pose2D pose;
  Matrix3 information = Matrix3::Zero();  ///< of scan and prior together, at `pose`
  double agreement = 0.0;  ///< the share of hits in known space that lie on a surface
  int known_hits = 0;      ///< how many hits lie in known space
};

/// The most likely pose given the scan and a Gaussian belief (mean `prior`, inverse covariance `prior_information`):
/// Gauss-Newton on robust point-to-surface distances, starting at `start`. `beams`: in the base frame.
Match match_scan(const map::LogOddsMap& map, std::span<const map::Beam> beams, const Pose2D& prior,
                 const Matrix3& prior_information, const Pose2D& start);

/// How wide to search.
struct SearchWindow {
  double position = 0.3;  ///< [m] each way
  double heading = 0.15;  ///< [rad] each way
};

/// The pose around `center` from which most hits fall on occupied cells; every pose in the window is tried, in steps of
/// a cell and 1 degree. Nearer poses win ties.
Pose2D search_pose(const map::LogOddsMap& map, std::span<const map::Beam> beams, const Pose2D& center,
                   const SearchWindow& window);

}  // namespace threewe::slam
