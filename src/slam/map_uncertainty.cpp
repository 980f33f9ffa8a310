#include "slam/map_uncertainty.hpp"

#include <algorithm>

#include <Eigen/LU>

#include "core/exact.hpp"
#include "slam/pose_covariance.hpp"

namespace threewe::slam {
namespace {

// Fitted to ten-minute drives in all scenes, with plain and with bad sensors, by verify_trajectory on seeds from
// 1000000 on: so that mean squared errors over these covariances are as alike as may be.
constexpr double kCarried = 2.4;     // errors of one scan's fit, of which much is not its own: they pass into the map
constexpr double kOrigin = 0.003;    // [m] of the robot's own place so much comes and goes on a few metres ...
constexpr double kHeading = 0.0009;  // [rad] ... and so much of its heading
constexpr double kStretch = 0.0005;  // of the way from where the map began
constexpr double kUsual = 0.0115;    // [m] all that with a lidar that scatters so much, and in proportion ...
constexpr double kLeast = 0.5;       // ... but no less than this: there are other errors

constexpr double kPosition = 0.03;  // [m] by its motion a robot knows its place that well, if scans do not tell it ...
constexpr double kTurn = 0.03;      // [rad]

constexpr double kApart = 1.0;  // [m] between places that are remembered
constexpr double kNear = 1.5;   // [m] from one, much the same is seen as from there ...
constexpr double kWay = 4.0;    // [m] ... if it was left so long ago that what is seen is not all the same anyway

double square(double x) { return x * x; }

// What a view's errors, squared, are more than its information says, with a lidar that scatters so many times the
// usual: up to 1.5 times the information says it all (3we_standard_v2, turtlebot_like), at four times (randomization
// `hard`) errors are far greater.
double by_scatter(double worse) {
  constexpr double kInProportion = 1.5;
  const double beyond = worse / kInProportion;
  return worse < 1.0 ? square(worse) : std::max(1.0, beyond * beyond * beyond);
}

Matrix3 covariance_of(const Matrix3& information) {
  const Matrix3 by_motion = Vector3(1.0 / square(kPosition), 1.0 / square(kPosition), 1.0 / square(kTurn)).asDiagonal();
  const Matrix3 covariance = (information + by_motion).inverse();
  return 0.5 * (covariance + covariance.transpose());
}

}  // namespace

void MapUncertainty::update(Vec2 position, const View& view) {
  if (!began_) origin_ = position;
  const Vec2 moved = began_ ? position - here_.position : Vec2{};
  worse_ = std::max(view.scatter / kUsual, kLeast);
  // a little that is new counts for little, and is later judged beside much that was there before
  const double added = by_scatter(worse_) * (began_ ? view.unknown * exact::sqrt(view.unknown) : 1.0);
  began_ = true;
  here_.covariance = composed({}, here_.covariance, {moved.x, moved.y, 0.0}, covariance_of(view.information) * added);
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
    alone = alone && away >= kApart;
    if (away >= kNear || (!elsewhere_ && here_.driven - place.driven < kWay)) continue;
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
  const Vector3 here(square(kOrigin), square(kOrigin), square(kHeading));
  const Vec2 way = here_.position - origin_;
  const Vector3 stretched = kStretch * Vector3(way.x, way.y, 0.0);
  return square(kCarried) * here_.covariance + Matrix3((square(worse_) * here).asDiagonal()) +
         stretched * stretched.transpose();
}

}  // namespace threewe::slam
