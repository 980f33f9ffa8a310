#include "slam/map_uncertainty.hpp"

#include <algorithm>

#include <Eigen/LU>

#include "core/exact.hpp"
#include "slam/pose_covariance.hpp"

namespace threewe::slam {
namespace {

double square(double x) { return x * x; }

// What a view's errors, squared, are more than its information says, with a lidar that scatters so many times the
// usual: up to 1.5 times the information says it all (3we_standard_v2, turtlebot_like), at four times (randomization
// `hard`) errors are far greater.
double by_scatter(double worse, const Params::MapUncertainty& params) {
  const double beyond = worse / params.in_proportion;
  return worse < 1.0 ? square(worse) : std::max(1.0, beyond * beyond * beyond);
}

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
  // a little that is new counts for little, and is later judged beside much that was there before
  const double added = by_scatter(worse_, params_) * (began_ ? view.unknown * exact::sqrt(view.unknown) : 1.0);
  began_ = true;
  here_.covariance =
      composed({}, here_.covariance, {moved.x, moved.y, 0.0}, covariance_of(view.information, params_) * added);
  here_.position = position;
  here_.driven += norm(moved);
  here_.views += added;
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
