// Validation of a SlamConfig.
#pragma once

#include "threewe/slam/slam.hpp"

namespace threewe::slam {

/// Throws ContractError where a figure is out of its range.
void check(const SlamConfig& config);

}  // namespace threewe::slam
