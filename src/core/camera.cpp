#include "threewe/core/camera.hpp"

#include <atomic>
#include <cmath>
#include <mutex>
#include <utility>

#include <fmt/format.h>

#include "core/exact.hpp"
#include "threewe/core/errors.hpp"

namespace threewe {
namespace {

constexpr int kMaxSide = 16384;         // [px]
constexpr long kMaxPixels = 1L << 26U;  // of one image
constexpr double kShortest = 1e-2;      // [px]
constexpr double kFarthestPixel = 1e6;  // [px]

}  // namespace

CameraIntrinsics make_intrinsics(int width, int height, double horizontal_fov) {
  const bool fov_ok = horizontal_fov > 0.0 && horizontal_fov < exact::kPi;
  if (!fov_ok)
    throw ConfigError(fmt::format("a camera's horizontal_fov of {} rad: it must be in (0, pi)", horizontal_fov));
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
  const auto focal_ok = [](double f) { return f >= kShortest && f <= kFarthestPixel; };
  const auto centre_ok = [](double c) { return std::fabs(c) <= kFarthestPixel; };
  if (!focal_ok(fx) || !focal_ok(fy) || !centre_ok(cx) || !centre_ok(cy)) {
    throw ConfigError(
        fmt::format("camera with fx = {}, fy = {}, cx = {}, cy = {}: focal lengths must be {} to {} pixels, the "
                    "principal point within {} pixels of the corner",
                    fx, fy, cx, cy, kShortest, kFarthestPixel, kFarthestPixel));
  }
}

/// Where a picture is drawn once.
struct Picture::Canvas {
  std::once_flag once;
  std::atomic<bool> drawn = false;
  std::function<RGBDImage()> draw;
  RGBDImage image;
};

Picture::Picture(RGBDImage image) : canvas_(std::make_shared<Canvas>()) {
  canvas_->image = std::move(image);
  std::call_once(canvas_->once, [this] { canvas_->drawn = true; });
}

Picture::Picture(std::function<RGBDImage()> draw) : canvas_(std::make_shared<Canvas>()) {
  canvas_->draw = std::move(draw);
}

const RGBDImage& Picture::image() const {
  static const RGBDImage kEmpty;
  if (!canvas_) return kEmpty;
  std::call_once(canvas_->once, [this] {
    canvas_->image = std::exchange(canvas_->draw, nullptr)();
    canvas_->drawn = true;
  });
  return canvas_->image;
}

bool Picture::is_drawn() const { return !canvas_ || canvas_->drawn; }

}  // namespace threewe
