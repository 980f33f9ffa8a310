#include "threewe/safety/scan_points.hpp"

#include <cstddef>

#include "threewe/core/exact.hpp"

namespace threewe::safety {

void append_scan_points(const LidarSpec& lidar, std::span<const float> ranges, const Pose2D& odom_from_base_at_begin,
                        const Pose2D& odom_from_base_at_end, std::vector<Vec2>& points, double longest) {
  const auto beams = static_cast<double>(ranges.size());
  const double increment = 2.0 * exact::kPi / beams;
  const Pose2D begin = odom_from_base_at_begin * lidar.base_from_lidar;
  const Pose2D end = odom_from_base_at_end * lidar.base_from_lidar;
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const auto range = static_cast<double>(ranges[i]);
    if (range < lidar.range_min || range >= lidar.range_max || range > longest) continue;
    const double counted = (static_cast<double>(i) + 0.5) / beams;
    const double share = lidar.rolling ? (lidar.clockwise ? 1.0 - counted : counted) : 1.0;
    const Pose2D odom_from_lidar = interpolate(begin, end, share);
    const double angle = odom_from_lidar.theta - exact::kPi + static_cast<double>(i) * increment;
    points.push_back(odom_from_lidar.position() + range * rotate({1.0, 0.0}, angle));
  }
}

}  // namespace threewe::safety
