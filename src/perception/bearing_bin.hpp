// Bearing bins: in which of 360 equal parts of a turn a direction is.
#pragma once

#include <cstddef>

#include "threewe/core/pose.hpp"

namespace threewe::perception {

inline constexpr std::size_t kBearingBins = 360;

/// The bin that holds the bearing of `d`, the first one beginning at -pi: exactly as its arc tangent says, which is
/// computed only where `d` lies next to a border, or far from bin `near`. Fast where directions follow each other.
std::size_t bearing_bin(Vec2 d, std::size_t near);

}  // namespace threewe::perception
