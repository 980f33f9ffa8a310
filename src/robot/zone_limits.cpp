#include "robot/zone_limits.hpp"

#include <algorithm>

#include "core/exact.hpp"

namespace threewe {
namespace {

// [s] from a command to what it does, and of the control period before it.
constexpr double kReaction = 0.1;
// Of the braking that the profile allows.
constexpr double kGentle = 0.5;
// [s] ahead, where a velocity leads.
constexpr double kAhead = 0.1;

}  // namespace

Velocity within_zones(const RobotProfile& robot, std::span<const map::Zone> zones, const Pose2D& map_from_base,
                      const Velocity& velocity) {
  const double speed = exact::hypot(velocity.vx, velocity.vy);
  const Vec2 here = map_from_base.position();
  const Vec2 there = (map_from_base * Pose2D{kAhead * velocity.vx, kAhead * velocity.vy, 0.0}).position();
  double most = speed;
  for (const map::Zone& zone : zones) {
    const double now = zone.distance_to(here);
    if (!zone.speed_limit && (now == 0.0 || zone.distance_to(there) >= now)) continue;
    const double limit = zone.speed_limit.value_or(0.0);
    const double away = std::max(0.0, now - robot.body.footprint.circumscribed_radius() - kReaction * speed);
    const double braking = kGentle * robot.operating_limits.linear_braking;
    most = std::min(most, exact::sqrt(limit * limit + 2.0 * braking * away));
  }
  const double share = speed > most ? most / speed : 1.0;
  return {share * velocity.vx, share * velocity.vy, velocity.omega};
}

}  // namespace threewe
