#include "slam/map_uncertainty.hpp"

#include <algorithm>

#include <Eigen/LU>

#include "core/exact.hpp"
#include "core/numbers.hpp"
#include "slam/pose_covariance.hpp"

namespace threewe::slam {
namespace {

Matrix3 covariance_of(const Matrix3& information, const Params::MapUncertainty& params) {
  const Matrix3 by_motion = Vector3(1.0 / square(params.motion_position), 1.0 / square(params.motion_position),
                                    1.0 / square(params.motion_heading))
                                .asDiagonal();
  const Matrix3 covariance = (information + by_motion).inverse();
  return 0.5 * (covariance + covariance.transpose());
}

}  // namespace

void MapUncertainty::update(Vec2 position, const View& view) {
  if (!began_) origin_ = position;
  const Vec2 moved = began_ ? position - here_.position : Vec2{};
  worse_ = std::max(view.scatter / params_.usual_noise, params_.least_noise);
  const double scattered = square(std::min(worse_, 1.0));  // more is in the information already
  if (here_.driven + norm(moved) < params_.first_view) {
    // where it starts, many scans draw the same: the most certain of them counts
    const Matrix3 covariance = covariance_of(view.information, params_) * scattered;
    if (!began_ || covariance(2, 2) < here_.covariance(2, 2)) here_.covariance = covariance;
    here_.views = scattered;
  } else {
    // a little that is new counts for little, and is later judged beside much that was there before
    const double added = scattered * view.unknown * exact::sqrt(view.unknown);
    here_.covariance =
        composed({}, here_.covariance, {moved.x, moved.y, 0.0}, covariance_of(view.information, params_) * added);
    here_.views += added;
  }
  began_ = true;
  here_.position = position;
  here_.driven += norm(moved);
  come_back();
}

void MapUncertainty::forget_way() { elsewhere_ = true; }

// Takes over what was true of the best known place around; remembers this one, where there is none.
void MapUncertainty::come_back() {
  const Place* best = nullptr;
  bool alone = true;
  for (const Place& place : places_) {
    const double away = distance(place.position, here_.position);
    alone = alone && away >= params_.apart;
    if (away >= params_.near || (!elsewhere_ && here_.driven - place.driven < params_.way)) continue;
    if (best == nullptr || place.views < best->views) best = &place;
  }
  if (best != nullptr && (elsewhere_ || best->views < here_.views)) {
    const Vec2 moved = here_.position - best->position;
    here_.views = best->views;
    here_.covariance = composed({}, best->covariance, {moved.x, moved.y, 0.0}, Matrix3::Zero());
    elsewhere_ = false;
  }
  if (alone) places_.push_back(here_);
}

Matrix3 MapUncertainty::covariance() const {
  const Vector3 here(square(params_.position), square(params_.position), square(params_.heading));
  const Vec2 way = here_.position - origin_;
  const Vector3 stretched = params_.stretch * Vector3(way.x, way.y, 0.0);
  return square(params_.propagated) * here_.covariance + Matrix3((square(worse_) * here).asDiagonal()) +
         stretched * stretched.transpose();
}

}  // namespace threewe::slam
