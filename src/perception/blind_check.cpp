#include "perception/blind_check.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "core/exact.hpp"
#include "hardware/invalid_beams.hpp"
#include "safety/params.hpp"

namespace threewe::perception {
namespace {

// [m] between two parallel lines that the outline just fits in.
double narrowest(const Footprint& footprint) {
  const std::vector<Vec2>& corners = footprint.corners();
  double width = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2 side = corners[(i + 1) % corners.size()] - corners[i];
    double across = 0.0;
    for (const Vec2 corner : corners) across = std::max(across, cross(side, corner - corners[i]) / norm(side));
    width = std::min(width, across);
  }
  return width;
}

// [m] from the lidar to the front of a robot that has just come to a stop from full speed.
double stopping_distance(const RobotProfile& profile) {
  double body = 0.0;
  for (const Vec2 corner : profile.body.footprint.corners())
    body = std::max(body, distance(corner, profile.lidar->base_from_lidar.position()));
  const double speed = profile.operating_limits.linear;
  const double braking = profile.operating_limits.linear_braking;
  return body + safety::margin_of(profile) + speed * (to_seconds(profile.reaction()) + 0.5 * speed / braking);
}

}  // namespace

BlindCheck::BlindCheck(const RobotProfile& profile, const Params::Blind& params)
    : params_(params), base_from_lidar_(profile.lidar->base_from_lidar) {
  near_gap_ = near_gap(*profile.lidar);
  const double half = 0.5 * narrowest(profile.body.footprint);
  least_ = 2.0 * exact::atan2(half, stopping_distance(profile));
}

std::optional<BlindSector> BlindCheck::check(const LaserScan& scan, const Pose2D& at) {
  const std::vector<bool> near = remember_near(scan, at * base_from_lidar_);
  const auto is_near = [this](float range) { return range > 0.0F && static_cast<double>(range) < near_gap_; };
  std::size_t first = 0;
  std::size_t most = 0;
  for (const InvalidBeams& gap : invalid_beams(scan.ranges, 1)) {
    if (is_near(gap.before) || is_near(gap.after)) continue;
    std::size_t blind = 0;
    for (std::size_t i = 0; i < gap.count; ++i) {
      const std::size_t beam = (gap.first + i) % scan.ranges.size();
      blind = near[beam] ? 0 : blind + 1;
      if (blind <= most) continue;
      most = blind;
      first = gap.first + i + 1 - blind;
    }
  }
  if (most == 0 || static_cast<double>(most + 1) * scan.angle_increment <= least_) return std::nullopt;
  const double from = base_from_lidar_.theta + scan.angle_min + static_cast<double>(first) * scan.angle_increment;
  return BlindSector{wrap_angle(from), wrap_angle(from + static_cast<double>(most - 1) * scan.angle_increment)};
}

// What has come so near that the lidar does not see it any more is remembered while no beam looks there. Returns in
// which beams something near is, or was.
std::vector<bool> BlindCheck::remember_near(const LaserScan& scan, const Pose2D& odom_from_lidar) {
  const auto n = static_cast<std::ptrdiff_t>(scan.ranges.size());
  const double farthest = near_gap_ + params_.near;
  const auto beside = static_cast<std::ptrdiff_t>(params_.bearing / scan.angle_increment) + 1;
  std::vector<double> nearest(scan.ranges.size(), farthest);
  std::vector<bool> near(scan.ranges.size(), false);
  const auto note = [&](std::ptrdiff_t beam, double range) {
    double& known = nearest[static_cast<std::size_t>(beam)];
    known = std::min(known, range);
    for (std::ptrdiff_t i = beam - beside; i <= beam + beside; ++i) near[static_cast<std::size_t>((i + n) % n)] = true;
  };
  for (const Vec2 point : near_) {
    const Vec2 seen = inverse(odom_from_lidar) * point;
    const double angle = exact::atan2(seen.y, seen.x) - scan.angle_min;
    const auto beam = static_cast<std::ptrdiff_t>(std::floor(angle / scan.angle_increment + 0.5));
    const std::ptrdiff_t at = (beam % n + n) % n;
    if (scan.ranges[static_cast<std::size_t>(at)] <= 0.0F && norm(seen) < farthest) note(at, norm(seen));
  }
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const auto range = static_cast<double>(scan.ranges[static_cast<std::size_t>(i)]);
    if (range > 0.0 && range < farthest) note(i, range);
  }
  near_.clear();
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const double range = nearest[static_cast<std::size_t>(i)];
    if (range == farthest) continue;
    const double angle = scan.angle_min + static_cast<double>(i) * scan.angle_increment;
    near_.push_back(odom_from_lidar * rotate({range, 0.0}, angle));
  }
  return near;
}

}  // namespace threewe::perception
