#include "slam/loop_closer.hpp"

#include <algorithm>
#include <utility>

#include <Eigen/LU>

#include "core/exact.hpp"
#include "slam/scan_matcher.hpp"

namespace threewe::slam {
namespace {

constexpr double kDeviations = 3.0;      // of the belief are searched
constexpr double kLeastReach = 0.3;      // [m] ... but never less
constexpr double kMostReach = 10.0;      // [m] ... or more: whoever is so lost needs more than one view
constexpr double kLeastTurn = 0.1;       // [rad]
constexpr double kLeastScore = 0.55;     // Hess et al. 2016
constexpr double kDistinct = 0.85;       // of the score, which no other place in the window may reach
constexpr double kAgreement = 0.80;      // of the hits in known space lie on surfaces
constexpr double kKnownShare = 0.5;      // of the hits lie in known space ...
constexpr int kKnownHits = 40;           // ... and so many of each scan
constexpr double kMostDeviation = 0.05;  // [m] a corridor's walls alone do not tell how far along it the robot is
constexpr double kMostChi = 16.0;        // of three numbers: right by chance once in 900 times
constexpr double kFloor = 0.02;          // [m] a closure is not known better: both maps are a little bent
constexpr double kTurnFloor = 0.003;     // [rad]
constexpr double kWeakPrior = 0.3;       // [m] keeps what scans do not tell near where the search had it
constexpr double kWeakTurn = 0.1;        // [rad]
constexpr double kBiasSigma = 0.001;     // [m] of the range bias, which is known from the way here

double square(double x) { return x * x; }

BranchAndBoundMatcher::Window window_of(const PoseBelief& belief) {
  const auto reach = [&](int i) { return kDeviations * exact::sqrt(belief.covariance(i, i)); };
  return {belief.pose,
          {std::clamp(reach(kX), kLeastReach, kMostReach), std::clamp(reach(kY), kLeastReach, kMostReach)},
          std::clamp(reach(kTheta), kLeastTurn, exact::kPi)};
}

// How sure the scans alone are: like one scan, for all share the errors of the map.
Matrix3 covariance_of(const Match& match, const Matrix4& prior, int scans) {
  const Matrix3 told = (match.information - prior).topLeftCorner<3, 3>() / scans;
  const Matrix3 weak = prior.topLeftCorner<3, 3>();
  const Matrix3 floor = Vector3(square(kFloor), square(kFloor), square(kTurnFloor)).asDiagonal();
  return (told + weak).inverse() + floor;
}

double most_deviation(const Matrix3& covariance) {
  const double half_trace = 0.5 * (covariance(kX, kX) + covariance(kY, kY));
  return exact::sqrt(half_trace + exact::hypot(0.5 * (covariance(kX, kX) - covariance(kY, kY)), covariance(kX, kY)));
}

// How far a found pose is from where it was thought to be, in the deviations of both.
double chi_squared(const LoopMatch& found, const PoseBelief& belief) {
  const Vector3 off(found.map_from_base.x - belief.pose.x, found.map_from_base.y - belief.pose.y,
                    wrap_angle(found.map_from_base.theta - belief.pose.theta));
  return off.dot((belief.covariance + found.covariance).inverse() * off);
}

}  // namespace

LoopCloser::LoopCloser(map::LogOddsMap map) : map_(std::move(map)), search_(map_.grid()) {}

std::optional<LoopMatch> LoopCloser::find(std::span<const map::Beam> view, int scans, const PoseBelief& belief,
                                          double range_bias) const {
  const auto seen = search_.find(view, window_of(belief), kLeastScore);
  if (!seen || seen->elsewhere > kDistinct * seen->score) return {};

  const Matrix4 prior =
      Vector4(1.0 / square(kWeakPrior), 1.0 / square(kWeakPrior), 1.0 / square(kWeakTurn), 1.0 / square(kBiasSigma))
          .asDiagonal();
  const Match match = match_scan(map_, view, {seen->pose, range_bias}, prior, seen->pose, 0.0, Directions::all);
  const auto hits = std::ranges::count_if(view, [](const map::Beam& beam) { return beam.hit; });
  const double enough = std::max<double>(kKnownHits * scans, kKnownShare * static_cast<double>(hits));
  if (match.agreement < kAgreement || match.known_hits < enough) return {};

  LoopMatch found{match.at.pose, covariance_of(match, prior, scans), seen->score, match.agreement};
  if (most_deviation(found.covariance) > kMostDeviation || chi_squared(found, belief) > kMostChi) return {};
  return found;
}

std::size_t LoopCloser::bytes() const {
  return search_.bytes() + map_.hits().size() * (sizeof(map::CellHits) + sizeof(std::uint32_t));
}

}  // namespace threewe::slam
