#include "threewe/core/camera.hpp"

#include <cmath>

#include <fmt/format.h>

#include "threewe/core/errors.hpp"
#include "threewe/core/exact.hpp"

namespace threewe {
namespace {

constexpr int kMaxSide = 16384;         // [px]
constexpr long kMaxPixels = 1L << 26U;  // of one image
constexpr double kShortest = 1e-2;      // [px]
constexpr double kFarthest = 1e6;       // [px]

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
  const auto focal_ok = [](double f) { return f >= kShortest && f <= kFarthest; };
  const auto centre_ok = [](double c) { return std::fabs(c) <= kFarthest; };
  if (!focal_ok(fx) || !focal_ok(fy) || !centre_ok(cx) || !centre_ok(cy)) {
    throw ConfigError(
        fmt::format("camera with fx = {}, fy = {}, cx = {}, cy = {}: focal lengths must be {} to {} pixels, the "
                    "principal point within {} pixels of the corner",
                    fx, fy, cx, cy, kShortest, kFarthest, kFarthest));
  }
}

}  // namespace threewe
