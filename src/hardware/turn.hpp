// Time at which the turn of a lidar ended whose scan has arrived.
#pragma once

#include "threewe/core/samples.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe {

/// From the scan's stamps, to the microsecond. `measured` is the time of its beam 0.
Time end_of_turn(const LidarSpec& lidar, const LaserScan& scan, Time measured);

}  // namespace threewe
