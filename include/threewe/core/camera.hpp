// Pinhole camera intrinsics, and the images that a camera delivers.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace threewe {

/// A pinhole without distortion. Column and row of a pixel's centre are whole numbers + 0.5; x grows to the right, y
/// downwards. A point (x forward, y left, z up) of the camera's frame is seen at (cx - fx y/x, cy - fy z/x).
struct CameraIntrinsics {
  int width = 0;    ///< [px]
  int height = 0;   ///< [px]
  double fx = 0.0;  ///< [px]
  double fy = 0.0;  ///< [px]
  double cx = 0.0;  ///< [px]
  double cy = 0.0;  ///< [px]
  friend bool operator==(const CameraIntrinsics&, const CameraIntrinsics&) = default;
};

/// The camera of an image size that sees `horizontal_fov` [rad] with square pixels, its axis in the middle.
/// Throws ConfigError unless the view is in (0, pi).
CameraIntrinsics make_intrinsics(int width, int height, double horizontal_fov);

/// Throws ConfigError when an image has no pixels or too many, or its focal lengths are not positive and finite.
void check(const CameraIntrinsics& camera);

/// One image of a camera.
struct RGBDImage {
  CameraIntrinsics intrinsics;      ///< of both images
  std::vector<std::uint8_t> color;  ///< (H, W, 3), blue, green, red
  std::vector<float> depth;         ///< (H, W) [m] along the optical axis, invalid = 0.0; empty without a depth camera
  friend bool operator==(const RGBDImage&, const RGBDImage&) = default;
};

/// What is truly there to be seen.
struct SemanticImage {
  RGBDImage image;                 ///< without noise; depth without limits, 0 where there is nothing
  std::vector<std::int16_t> ids;   ///< (H, W), of what each pixel shows
  std::vector<std::string> names;  ///< by id: "nothing", "floor", "wall", "ceiling", then objects, people, robots
};

/// An image that a simulator draws on first access, so that images that are not accessed cost nothing. Copies share
/// it; it never changes.
class Picture {
 public:
  /// Of nothing: no pixels.
  Picture() = default;
  /// Of an image that is there already.
  explicit Picture(RGBDImage image);
  /// `draw` is called at most once, on first access, and must give the same on every thread.
  explicit Picture(std::function<RGBDImage()> draw);

  /// The image, drawn first where that has not been done. Any thread may ask. Throws what drawing throws.
  const RGBDImage& image() const;
  /// False before the first access.
  bool is_drawn() const;

 private:
  struct Canvas;
  std::shared_ptr<Canvas> canvas_;
};

}  // namespace threewe
