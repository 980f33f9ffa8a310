#include "vision/view.hpp"

#include <algorithm>
#include <cmath>

namespace threewe::vision {
namespace {

// The picture's row or column that is nearest to each half pixel of the view.
std::vector<std::size_t> nearest(int view, double focal, double center, int size) {
  std::vector<std::size_t> indices(static_cast<std::size_t>(2 * view));
  for (int i = 0; i < 2 * view; ++i) {
    const double slope = (0.5 * i + 0.25 - 0.5 * view) / kViewFocal;
    const double at = std::clamp(std::floor(center + focal * slope), 0.0, static_cast<double>(size - 1));
    indices[static_cast<std::size_t>(i)] = static_cast<std::size_t>(at);
  }
  return indices;
}

}  // namespace

std::vector<std::uint8_t> detector_view(std::span<const std::uint8_t> picture, const CameraIntrinsics& camera) {
  const auto columns = nearest(kViewWidth, camera.fx, camera.cx, camera.width);
  const auto rows = nearest(kViewHeight, camera.fy, camera.cy, camera.height);
  const auto row = 3 * static_cast<std::size_t>(camera.width);
  std::vector<std::uint8_t> view(3UL * kViewWidth * kViewHeight);
  std::uint8_t* to = view.data();
  for (std::size_t y = 0; y < rows.size(); y += 2) {
    const std::uint8_t* upper = picture.data() + rows[y] * row;
    const std::uint8_t* lower = picture.data() + rows[y + 1] * row;
    for (std::size_t x = 0; x < columns.size(); x += 2) {
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t left = 3 * columns[x] + c;
        const std::size_t right = 3 * columns[x + 1] + c;
        *to++ = static_cast<std::uint8_t>((upper[left] + upper[right] + lower[left] + lower[right] + 2) >> 2);
      }
    }
  }
  return view;
}

}  // namespace threewe::vision
