#include "threewe/core/camera.hpp"

#include <cmath>

#include <fmt/format.h>

#include "threewe/core/errors.hpp"
#include "threewe/core/exact.hpp"

namespace threewe {
namespace {

constexpr int kMaxSide = 16384;         // [px]
constexpr long kMaxPixels = 1L << 26U;  // of one image

}  // namespace

CameraIntrinsics make_intrinsics(int width, int height, double horizontal_fov) {
  const auto [s, c] = exact::sincos(0.5 * horizontal_fov);
  const double focal = 0.5 * width * c / s;
  return {width, height, focal, focal, 0.5 * width, 0.5 * height};
}

void check(const CameraIntrinsics& camera) {
  const auto [width, height, fx, fy, cx, cy] = camera;
  const bool sides_ok = width >= 1 && height >= 1 && width <= kMaxSide && height <= kMaxSide;
  if (!sides_ok || static_cast<long>(width) * height > kMaxPixels) {
    throw ConfigError(
        fmt::format("a camera image of {} x {} pixels: sides must be 1 to {}, and at most {} pixels in all", width,
                    height, kMaxSide, kMaxPixels));
  }
  if (!(fx > 0.0 && fy > 0.0 && std::isfinite(fx) && std::isfinite(fy) && std::isfinite(cx) && std::isfinite(cy))) {
    throw ConfigError(
        fmt::format("camera with fx = {}, fy = {}, cx = {}, cy = {}: focal lengths must be positive, all "
                    "must be finite",
                    fx, fy, cx, cy));
  }
}

}  // namespace threewe
