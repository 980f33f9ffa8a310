#include "slam/loop_closer.hpp"

#include <algorithm>
#include <utility>

#include <Eigen/LU>

#include "core/exact.hpp"
#include "core/numbers.hpp"
#include "slam/scan_matcher.hpp"

namespace threewe::slam {
namespace {

BranchAndBoundMatcher::Window window_of(const PoseBelief& belief, const Params::LoopCloser& params) {
  const auto reach = [&](int i) { return 3.0 * exact::sqrt(belief.covariance(i, i)); };
  return {belief.pose,
          {std::clamp(reach(kX), params.least_reach, params.most_reach),
           std::clamp(reach(kY), params.least_reach, params.most_reach)},
          std::clamp(reach(kTheta), params.least_turn, exact::kPi)};
}

// How sure the scans alone are: like one scan, for all share the errors of the map.
Matrix3 covariance_of(const Match& match, const Matrix4& prior, int scans, const Params::LoopCloser& params) {
  const Matrix3 informed = (match.information - prior).topLeftCorner<3, 3>() / scans;
  const Matrix3 weak = prior.topLeftCorner<3, 3>();
  const Matrix3 floor = Vector3(square(params.floor), square(params.floor), square(params.turn_floor)).asDiagonal();
  return (informed + weak).inverse() + floor;
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

LoopCloser::LoopCloser(map::LogOddsMap map, SharedParams params)
    : params_(std::move(params)), map_(std::move(map)), search_(map_.grid(), params_->global_search) {}

std::optional<LoopMatch> LoopCloser::find(std::span<const map::Beam> view, int scans, const PoseBelief& belief,
                                          double range_bias) const {
  const Params::LoopCloser& params = params_->loop_closer;
  const auto seen = search_.find(view, window_of(belief, params), params.least_score);
  if (!seen || seen->elsewhere > params.distinct * seen->score) return {};

  const Matrix4 prior = free_prior(params_->matching);
  const Match match =
      match_scan(map_, view, {seen->pose, range_bias}, prior, seen->pose, 0.0, Directions::all, params_->matching);
  const auto hits = std::ranges::count_if(view, [](const map::Beam& beam) { return beam.hit; });
  const double enough =
      std::max<double>(params.known_hits * scans, params_->registration.known_share * static_cast<double>(hits));
  if (match.agreement < params.agreement || match.known_hits < enough) return {};

  LoopMatch found{match.at.pose, covariance_of(match, prior, scans, params), seen->score, match.agreement};
  if (most_deviation(found.covariance) > params.most_deviation || chi_squared(found, belief) > params.most_chi)
    return {};
  return found;
}

std::size_t LoopCloser::bytes() const {
  return search_.bytes() + map_.hits().size() * (sizeof(map::CellHits) + sizeof(std::uint32_t));
}

}  // namespace threewe::slam
