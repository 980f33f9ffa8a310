// Scan-matching localizer: localization and mapping by wheels, gyro and lidar.
#pragma once

#include <memory>

#include "slam/params.hpp"
#include "slam/sensor_model.hpp"
#include "threewe/slam/localizer.hpp"

namespace threewe::slam {

/// Scan-to-map localisation on top of dead reckoning, see `src/slam/scan_matching_localizer.cpp` for the story. A robot
/// that is lost is searched for in the whole map: in the one that was given, or in its own.
std::unique_ptr<Localizer> make_scan_matching_localizer(const SensorModel& sensors, const InitialState& initial = {},
                                                        const SharedParams& params = reference_params());

}  // namespace threewe::slam
