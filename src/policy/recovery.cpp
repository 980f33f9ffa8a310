#include "policy/recovery.hpp"

#include <algorithm>
#include <limits>
#include <vector>

#include "core/exact.hpp"
#include "core/outline.hpp"

namespace threewe::policy {
namespace {

constexpr Duration kPatience = from_seconds(0.5);  // that the gate stops the robot before it moves away
constexpr double kSpeed = 0.3;                     // of the fastest that it may drive
constexpr double kFirst = 0.5;                     // [s] that it moves away for the first time
constexpr double kLonger = 1.6;                    // times as long when it is stopped again ...
constexpr double kAgain = 4.0;                     // [s] ... so soon
constexpr double kLongest = 2.0;                   // [s]
constexpr double kAsNear = 0.02;                   // [m] farther than the nearest point counts as much
constexpr double kUndecided = 0.1;  // of a length of 1, below which points on both sides leave no direction
constexpr double kBehind = 0.5;  // of a direction along x: what is nearest is behind a base that cannot move sideways

}  // namespace

Vec2 away_from_nearest(const Footprint& footprint, std::span<const Vec2> points) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Vec2 point : points) nearest = std::min(nearest, footprint.signed_distance(point));
  Vec2 sum;
  for (const Vec2 point : points) {
    if (footprint.signed_distance(point) > nearest + kAsNear) continue;
    const Vec2 out = point - closest_on_outline(point, footprint.corners());
    const double length = footprint.contains(point) ? -norm(out) : norm(out);
    if (length != 0.0) sum = sum - (1.0 / length) * out;
  }
  const double length = norm(sum);
  return length < kUndecided ? Vec2{} : (1.0 / length) * sum;
}

Recovery::Recovery(const RobotProfile& profile)
    : footprint_(profile.body.footprint),
      base_from_lidar_(profile.lidar ? profile.lidar->base_from_lidar : Pose2D{}),
      sideways_(profile.kinematics() == Kinematics::holonomic),
      speed_(kSpeed * profile.operating_limits.linear) {}

Velocity Recovery::next(Time now, const Velocity& wanted, bool stopped, const LaserScan* scan) {
  if (now < until_) return moving_;
  if (!stopped || wanted == Velocity{})
    stopped_since_.reset();
  else if (!stopped_since_)
    stopped_since_ = now;
  if (!stopped_since_ || now - *stopped_since_ < kPatience) return wanted;
  const bool again = count_ > 0 && to_seconds(now - until_) < kAgain;
  lasts_ = again ? std::min(kLongest, kLonger * lasts_) : kFirst;
  until_ = now + from_seconds(lasts_);
  stopped_since_.reset();
  ++count_;
  moving_ = away(wanted, scan);
  return moving_;
}

Velocity Recovery::away(const Velocity& wanted, const LaserScan* scan) const {
  std::vector<Vec2> points;
  for (std::size_t i = 0; scan != nullptr && i < scan->ranges.size(); ++i) {
    const double range = scan->ranges[i];
    if (range < scan->range_min || range >= scan->range_max) continue;
    const exact::SinCos beam = exact::sincos(scan->angle_min + static_cast<double>(i) * scan->angle_increment);
    points.push_back(base_from_lidar_ * Vec2{range * beam.cos, range * beam.sin});
  }
  Vec2 direction = away_from_nearest(footprint_, points);
  if (direction == Vec2{}) direction = Vec2{-wanted.vx, -wanted.vy};
  if (!sideways_) direction = {direction.x > kBehind ? 1.0 : -1.0, 0.0};
  const double length = norm(direction);
  if (length == 0.0) return {-speed_, 0.0, 0.0};
  return {speed_ / length * direction.x, speed_ / length * direction.y, 0.0};
}

}  // namespace threewe::policy
