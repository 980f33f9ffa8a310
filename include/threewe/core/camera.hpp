// What a camera is: how its pixels look into space.
#pragma once

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
CameraIntrinsics make_intrinsics(int width, int height, double horizontal_fov);

/// Throws ConfigError when an image has no pixels or too many, or its focal lengths are not positive and finite.
void check(const CameraIntrinsics& camera);

}  // namespace threewe
