#include "nav/mppi/pursuit.hpp"
#include "core/exact.hpp"

#include <algorithm>
#include <cmath>

namespace threewe::nav::mppi {
namespace {

// The velocity towards a point in the base frame.
Velocity towards(Vec2 target, double heading, double speed, const Limits& limits, Kinematics kinematics,
                 const PursuitParams& params) {
  const double away = norm(target);
  const double rate = std::clamp(params.heading_gain * heading, -limits.angular, limits.angular);
  if (away < 1e-3) return {0.0, 0.0, rate};
  if (kinematics == Kinematics::holonomic) return {speed * target.x / away, speed * target.y / away, rate};
  if (std::fabs(heading) > params.turn_first) return {0.0, 0.0, rate};
  const double curvature = 2.0 * target.y / (away * away);
  return {target.x > 0.0 ? speed : -speed, 0.0, std::clamp(speed * curvature, -limits.angular, limits.angular)};
}

}  // namespace

Plan pursue(const PathTable& path, const MppiTask& task, const Limits& limits, Kinematics kinematics, double step,
            const Pose2D& start, const PursuitParams& params) {
  Plan plan;
  Pose2D pose = start;
  double along = 0.0;
  double turn_left = task.turn.value_or(0.0);
  for (std::size_t i = 0; i < kSteps; ++i) {
    Velocity v;
    if (task.turn) {
      v.omega = std::clamp(params.position_gain * turn_left, -limits.angular, limits.angular);
      turn_left -= step * v.omega;
    } else {
      const Vec2 target = inverse(pose) * path.point(along + params.lookahead);
      const Vec2 faced = task.backwards ? Vec2{-target.x, -target.y} : target;
      const double heading = norm(target) < params.rest ? 0.0 : wrap_angle(exact::atan2(faced.y, faced.x) + task.aside);
      const double speed = std::min(limits.linear, params.position_gain * norm(target));
      v = towards(target, heading, speed, limits, kinematics, params);
      along = std::min(along + step * exact::hypot(v.vx, v.vy), path.length());
    }
    pose = integrate(pose, v, step);
    plan.vx[i] = static_cast<float>(v.vx);
    plan.vy[i] = static_cast<float>(v.vy);
    plan.omega[i] = static_cast<float>(v.omega);
  }
  return plan;
}

}  // namespace threewe::nav::mppi
