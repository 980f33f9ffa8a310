#include "core/bounds.hpp"

#include <cmath>

#include <fmt/format.h>

#include "threewe/core/errors.hpp"

namespace threewe {

void check_bounds(std::string_view name, Vec2 place) {
  if (is_bounded(place)) return;
  throw ContractError(
      fmt::format("{} must be finite and within 1000 km of the origin, got ({:g}, {:g})", name, place.x, place.y));
}

void check_bounds(std::string_view name, const Pose2D& pose) {
  check_bounds(name, pose.position());
  if (is_within(pose.theta, -kMaxAngle, kMaxAngle)) return;
  throw ContractError(fmt::format("{} must have a heading within +-{:g} rad, got {:g}", name, kMaxAngle, pose.theta));
}

void check_bounds(const LaserScan& scan) {
  const std::size_t beams = scan.ranges.size();
  if (beams > kMaxBeams)
    throw ContractError(fmt::format("a scan of {} ranges; at most {} are taken", beams, kMaxBeams));
  const double last = scan.angle_min + static_cast<double>(beams) * scan.angle_increment;
  if (!(scan.angle_increment > 0.0) || !is_within(scan.angle_min, -kMaxAngle, kMaxAngle) || !(last <= kMaxAngle)) {
    throw ContractError(
        fmt::format("a scan's angles must go up and stay within +-{:g} rad, got angle_min {:g}, angle_increment {:g}",
                    kMaxAngle, scan.angle_min, scan.angle_increment));
  }
  if (!(std::fabs(scan.time_increment) * static_cast<double>(beams) <= kMaxSweep)) {
    throw ContractError(fmt::format("a scan must take at most {:g} s, got {} times a time_increment of {:g}", kMaxSweep,
                                    beams, scan.time_increment));
  }
  if (!(scan.range_min >= 0.0) || !(scan.range_max > scan.range_min) || !is_bounded(scan.range_max)) {
    throw ContractError(fmt::format("a scan needs 0 <= range_min < range_max <= {:g}, got {:g} and {:g}",
                                    kMaxCoordinate, scan.range_min, scan.range_max));
  }
  for (std::size_t i = 0; i < beams; ++i) {
    if (scan.ranges[i] >= 0.0F && std::isfinite(scan.ranges[i])) continue;
    throw ContractError(
        fmt::format("range {} of a scan is {:g}: no return is range_max, invalid is 0", i, scan.ranges[i]));
  }
}

}  // namespace threewe
