// Lidar scan as obstacle points for the collision monitor.
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "threewe/core/pose.hpp"
#include "threewe/core/samples.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe::safety {

/// Appends where a scan's beams hit something, in the frame of the poses, given where the lidar was as the turn began
/// and as it ended; in between it is taken to have moved evenly. Beams longer than `longest` [m] are left out.
void append_scan_points(const LidarSpec& lidar, std::span<const float> ranges, const Pose2D& odom_from_lidar_at_begin,
                        const Pose2D& odom_from_lidar_at_end, std::vector<Vec2>& points,
                        double longest = std::numeric_limits<double>::infinity());

}  // namespace threewe::safety
