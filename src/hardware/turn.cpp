#include "hardware/turn.hpp"

#include <algorithm>

namespace threewe {

Time end_of_turn(const LidarSpec& lidar, const LaserScan& scan, Time measured) {
  if (scan.time_increment == 0.0 || scan.ranges.empty()) return measured;
  const auto beams = static_cast<Duration::rep>(scan.ranges.size());
  const Time other_end = measured + from_seconds(static_cast<double>(beams - 1) * scan.time_increment);
  // from the middle of the last beam to its edge, where the next turn's first point is, in the middle of its own share
  const Duration beyond = lidar.turn / (2 * beams) + lidar.turn / (2 * lidar.points_per_turn);
  constexpr Duration kStamp = 1us;
  return (std::max(measured, other_end) + beyond + kStamp / 2) / kStamp * kStamp;
}

}  // namespace threewe
