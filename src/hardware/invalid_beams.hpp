// Runs of a scan's invalid beams, and which of them stand for something too near to be measured.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "threewe/hardware/profile.hpp"

namespace threewe {

/// Invalid beams side by side, around the whole turn if need be, and the valid ones at both ends.
struct InvalidBeams {
  std::size_t first = 0;
  std::size_t count = 0;
  float before = 0.0F;  ///< [m] the range of the beam before the first; 0 where no beam is valid
  float after = 0.0F;   ///< [m] of that after the last
};

/// All runs of at least `fewest` invalid beams in a full turn.
std::vector<InvalidBeams> invalid_beams(std::span<const float> ranges, std::size_t fewest);

/// [beams] from an invalid beam to the nearest valid one: two that drop out side by side are no gap.
inline constexpr double kBridgedBeams = 1.5;

/// [m] where both beams beside a run are shorter, what is in it is nearer than the lidar can measure.
double near_gap(const LidarSpec& lidar);

}  // namespace threewe
