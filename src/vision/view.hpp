// View of the detector: any level pinhole picture as one of 320 x 240 pixels and 90 degrees.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "threewe/core/camera.hpp"

namespace threewe::vision {

inline constexpr int kViewWidth = 320;       ///< [px]
inline constexpr int kViewHeight = 240;      ///< [px]
inline constexpr double kViewFocal = 160.0;  ///< [px]

/// Each pixel of the view is the mean of the four pixels of the picture that are nearest to its quarters' centres;
/// beyond the picture's edge, of those at its edge.
std::vector<std::uint8_t> detector_view(std::span<const std::uint8_t> picture, const CameraIntrinsics& camera);

}  // namespace threewe::vision
