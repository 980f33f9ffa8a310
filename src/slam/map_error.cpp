#include "slam/map_error.hpp"

#include <algorithm>

#include "slam/pose_covariance.hpp"

namespace threewe::slam {
namespace {

// Fitted to ten-minute drives in all scenes by maximum likelihood, with verify_trajectory on seeds from 1000000 on.
constexpr double kTurn = 0.0013;     // [rad] a view that is new lies turned by so much against what was known ...
constexpr double kShift = 0.0038;    // [m] ... and shifted
constexpr double kOrigin = 0.005;    // [m] of the robot's own place so much comes and goes on a few metres ...
constexpr double kHeading = 0.0022;  // [rad] ... and so much of its heading

constexpr double kApart = 1.0;  // [m] between places that are remembered
constexpr double kNear = 1.5;   // [m] from one, much the same is seen as from there ...
constexpr double kWay = 4.0;    // [m] ... if it was left so long ago that what is seen is not all the same anyway

double square(double x) { return x * x; }

}  // namespace

void MapError::see(Vec2 position, double unknown) {
  const Vec2 moved = began_ ? position - here_.position : Vec2{};
  began_ = true;
  here_.turns = composed({}, here_.turns, {moved.x, moved.y, 0.0}, Matrix3::Zero());
  here_.position = position;
  here_.driven += norm(moved);
  here_.views += unknown;
  here_.turns(kTheta, kTheta) += unknown;
  come_back();
}

MapError::MapError() { here_.turns(kTheta, kTheta) = here_.views; }

void MapError::forget_way() { elsewhere_ = true; }

// Takes over what was true of the best known place around; remembers this one, where there is none.
void MapError::come_back() {
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
    here_.turns = composed({}, best->turns, {moved.x, moved.y, 0.0}, Matrix3::Zero());
    elsewhere_ = false;
  }
  if (alone) places_.push_back(here_);
}

Matrix3 MapError::covariance() const {
  const double position = square(kOrigin) + square(kShift) * here_.views;
  const Matrix3 beside = Vector3(position, position, square(kHeading)).asDiagonal();
  return square(kTurn) * here_.turns + beside;
}

}  // namespace threewe::slam
