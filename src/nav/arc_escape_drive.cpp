// A manoeuvre as it is driven.
#include <algorithm>
#include <cmath>

#include "core/exact.hpp"
#include "nav/arc_escape.hpp"

namespace threewe::nav {
namespace {

constexpr double kMostTolerances = 20.0;  // so often, the next plan allows for more

// [rad or m] of a step that is left, counted along it.
double left_of(const ArcStep& step, const Pose2D& odom_from_base) {
  const Velocity& v = step.direction;
  const Pose2D in_end = inverse(step.end) * odom_from_base;
  const double speed = exact::hypot(v.vx, v.vy);
  if (speed == 0.0) return -std::copysign(1.0, v.omega) * in_end.theta;
  // the end's heading is that of the velocity there
  return -(v.vx * in_end.x + v.vy * in_end.y) / speed;
}

}  // namespace

void ArcEscape::begin(Time now) {
  steps_.clear();
  plans_ = 0;
  tolerance_ = 0.0;
  over_ = creep_mode_ = false;
  moved_ = next_plan_ = now;
}

// Where hits leave no way they may be nearer than what they are of, by what they scatter: the next plan allows for a
// little more of that, while the gate has the last word on each step. False: there is no hope.
bool ArcEscape::plan(Time now, const Pose2D& odom_from_base, std::span<const Vec2> hits_in_base) {
  const bool in_vain = steps_.empty() && now - moved_ > 2 * params_.patience;
  steps_.clear();
  if (planner_.has_room(hits_in_base) || in_vain || plans_ > params_.plans) return false;
  if (now < next_plan_) return true;
  next_plan_ = now + params_.replan;
  steps_ = planner_.plan(hits_in_base, tolerance_);
  if (steps_.empty())
    tolerance_ = std::min(tolerance_ + params_.tolerance_step, kMostTolerances * params_.tolerance_step);
  if (steps_.empty()) return true;
  for (ArcStep& step : steps_) step.end = odom_from_base * step.end;
  ++plans_;
  moved_at_ = odom_from_base, moved_ = now;
  return true;
}

bool ArcEscape::stands_still(Time now, const Pose2D& odom_from_base) {
  const Pose2D since = inverse(moved_at_) * odom_from_base;
  if (norm(since.position()) > creep_.progress || std::fabs(since.theta) > params_.turned)
    moved_at_ = odom_from_base, moved_ = now;
  return now - moved_ > params_.patience;
}

Velocity ArcEscape::step(Time now, const Pose2D& odom_from_base, std::span<const Vec2> hits_in_base,
                         const PathFollower& follower) {
  creep_mode_ = planner_.is_tight(hits_in_base);
  while (!steps_.empty() && left_of(steps_.front(), odom_from_base) <= 0.0) steps_.erase(steps_.begin());
  const bool due = steps_.empty() || stands_still(now, odom_from_base);
  if (due && !plan(now, odom_from_base, hits_in_base)) over_ = true;
  if (steps_.empty()) return {};
  const Velocity velocity = along(steps_.front(), odom_from_base);
  return creep_mode_ && tolerance_ > 0.0 ? velocity : follower.safe(velocity);
}

// As fast as corners may move, and so that the step ends with the heading that was planned.
Velocity ArcEscape::along(const ArcStep& step, const Pose2D& odom_from_base) const {
  const Velocity& v = step.direction;
  const double speed = exact::hypot(v.vx, v.vy);
  const double most = creep_mode_ ? creep_.speed : std::min(creep_.free_speed, quick_.linear);
  const double most_turn =
      creep_mode_ ? creep_.corner_speed / planner_.radius() : std::min(creep_.free_turn_rate, quick_.angular);
  if (speed == 0.0) return {0.0, 0.0, std::copysign(most_turn, v.omega)};
  const double bend = v.omega / speed;
  const double target_speed = std::min(most, most_turn / std::max(std::fabs(bend), 1e-9));
  const double planned = step.end.theta - bend * std::max(left_of(step, odom_from_base), 0.0);
  const double off = wrap_angle(planned - odom_from_base.theta);
  const double omega = std::clamp(target_speed * (bend + off / params_.convergence), -most_turn, most_turn);
  return {target_speed * v.vx / speed, target_speed * v.vy / speed, omega};
}

}  // namespace threewe::nav
