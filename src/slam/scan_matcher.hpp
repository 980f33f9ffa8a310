// Scan-to-map matcher: local least squares against the surfaces of a map.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include <Eigen/Core>

#include "map/log_odds_map.hpp"
#include "slam/params.hpp"
#include "slam/pose_filter.hpp"
#include "threewe/core/pose.hpp"

namespace threewe::slam {

/// A piece of a mapped surface near a point.
struct Surface {
  Vec2 mean;            ///< [m] of the hits around, as measured
  Vec2 from;            ///< mean direction back to the sensor: with a range bias b the surface is at mean + b * from
  Vec2 normal;          ///< unit; of the line through them
  double spread = 0.0;  ///< [m^2] of the hits along the normal
  bool line = false;    ///< false: a spot, known in both directions alike
  double tilt = 0.0;    ///< [rad^2] variance of the normal's direction: few hits close together fix it badly
};

/// The surface at `point`, from the hits in the cells around it that were seen from a side that looks back along
/// `back`; empty where there are none. `scatter`: deviation of a range [m]; the larger it is, the more cells are looked
/// at: a mean over fewer than it spreads hits over would follow the point.
std::optional<Surface> surface_at(const map::LogOddsMap& map, Vec2 point, Vec2 back,
                                  const Params::Matching& params = {}, double scatter = 0.0);

/// What a scan tells about.
struct Placement {
  Pose2D pose;
  double range_bias = 0.0;  ///< [m] by which all ranges are too long
};

/// The distance [m] of a beam's hit from a surface along `direction`, and how it changes with (x, y, theta, range
/// bias). The bias moves the hit and, in the same way, the hits that made the surface: only a surface seen from
/// elsewhere tells about it.
struct Residual {
  double value = 0.0;
  Vector4 jacobian = Vector4::Zero();
};
Residual residual(const Surface& surface, Vec2 direction, const Placement& at, const map::Beam& beam_in_base);

/// Where a scan fits best.
struct Match {
  Placement at;
  Matrix4 information = Matrix4::Zero();       ///< of scan and prior together
  Matrix4 scan_information = Matrix4::Zero();  ///< of it, what the scan tells
  double agreement = 0.0;                      ///< the share of hits in known space that lie on a surface
  int known_hits = 0;                          ///< how many hits lie in known space
  std::optional<Vec2> unobserved;              ///< unit; along which the scan tells nothing of the position
};

/// Along which directions a scan tells the position. In a map of fine cells that a robot drew over many scans, noise of
/// the walls' normals seems to tell where it is along a bare corridor: only `observed` directions count then. A map of
/// a few scans metres apart tells too little for that to be judged: there it takes `all` directions.
enum class Directions : std::uint8_t { all, observed };

/// The most likely placement given the scan and a Gaussian belief (mean `prior`, inverse covariance
/// `prior_information`): Gauss-Newton on robust point-to-surface distances, starting at `start`. `beams`: in the base
/// frame. `scatter`: deviation of a range [m], where that is known; up to 12 mm other errors weigh more.
Match match_scan(const map::LogOddsMap& map, std::span<const map::Beam> beams, const Placement& prior,
                 const Matrix4& prior_information, const Pose2D& start, double scatter = 0.0,
                 Directions directions = Directions::observed, const Params::Matching& params = {});

/// Inverse covariance of a belief that leaves the pose to the scan and keeps what that does not tell, also of the range
/// bias.
Matrix4 free_prior(const Params::Matching& params);

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
