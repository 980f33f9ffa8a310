#include "hardware/limits.hpp"

#include <algorithm>
#include <cmath>

#include <hwy/highway.h>

#include "hardware/limits-inl.hpp"

namespace threewe {
namespace {

constexpr double kPeriod = to_seconds(kControlPeriod);
// what rounding may add, so that a velocity within reach stays as it is
constexpr double kRounding = 1.0 + 1e-12;

// Moves from `last` straight towards `target`, as far as one period allows: as long as the line comes nearer to
// stand-still it brakes, beyond that it speeds up with what is left of the period.
Vec2 approach(Vec2 last, Vec2 target, double braking, double acceleration) {
  const Vec2 change = target - last;
  const double at_least = std::min(braking, acceleration) * kPeriod;
  if (dot(change, change) <= at_least * at_least) return target;
  const double length = norm(change);

  const Vec2 direction = (1.0 / length) * change;
  const double slowing = std::clamp(-dot(last, direction), 0.0, length);  // length of the part that brakes
  const double braked = braking * kPeriod;
  if (slowing > braked * kRounding) return last + braked * direction;

  const double reach = slowing + acceleration * kPeriod * std::max(0.0, 1.0 - slowing / braked);
  return length <= reach * kRounding ? target : last + reach * direction;
}

}  // namespace

Velocity within_limits(const Limits& limits, Velocity v) {
  const auto [vx, vy, omega] =
      HWY_NAMESPACE::within_limits<double>(limits.linear, limits.angular, {v.vx, v.vy, v.omega});
  return {vx, vy, omega};
}

Velocity within_wheel_speed(const WheelGeometry& wheels, double speed, const Velocity& v) {
  double fastest = 0.0;
  for (const double turning : wheel_speeds(wheels, v)) fastest = std::max(fastest, std::abs(turning) * wheels.radius);
  if (fastest <= speed * kRounding) return v;
  const double share = speed / fastest;
  return {share * v.vx, share * v.vy, share * v.omega};
}

Velocity scaled_to(const Limits& limits, const Velocity& shares) {
  const auto scaled = [](double share, double limit) { return std::clamp(share, -1.0, 1.0) * limit; };
  return {scaled(shares.vx, limits.linear), scaled(shares.vy, limits.linear), scaled(shares.omega, limits.angular)};
}

Velocity within_acceleration(const Limits& limits, const Velocity& last, const Velocity& target) {
  const Vec2 linear =
      approach({last.vx, last.vy}, {target.vx, target.vy}, limits.linear_braking, limits.linear_acceleration);
  const Vec2 angular =
      approach({last.omega, 0.0}, {target.omega, 0.0}, limits.angular_acceleration, limits.angular_acceleration);
  return {linear.x, linear.y, angular.x};
}

}  // namespace threewe
