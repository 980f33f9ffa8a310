#include "robot/scan_track.hpp"

#include "core/exact.hpp"
#include "hardware/turn.hpp"
#include "safety/scan_points.hpp"

namespace threewe {

void ScanTrack::add_scan(const LaserScan& scan, Time measured) {
  LidarSpec lidar = *lidar_;
  lidar.rolling = scan.time_increment != 0.0;
  lidar.clockwise = scan.time_increment < 0.0;
  if (scan.angle_min != -exact::kPi) {
    lidar.base_from_lidar = lidar.base_from_lidar * Pose2D{0.0, 0.0, wrap_angle(scan.angle_min + exact::kPi)};
  }
  const Time end = end_of_turn(lidar, scan, measured);
  obstacles_.clear();
  safety::append_scan_points(lidar, scan.ranges, track_.at(end - lidar.turn) * lidar.base_from_lidar,
                             track_.at(end) * lidar.base_from_lidar, obstacles_);
}

}  // namespace threewe
