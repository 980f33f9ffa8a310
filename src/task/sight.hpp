// Exact visibility of an object in a level camera: counts of pixels, without a picture.
#pragma once

#include <span>

#include "threewe/core/camera.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/scene/solid.hpp"

namespace threewe::task {

/// A level camera's eye in the scene's frame, looking along the heading.
struct Eye {
  Pose2D pose;
  double height = 0.0;  ///< [m] above the floor
};

/// The number of pixels whose ray, through the pixel's centre, meets one of `object`'s solids before any of `others`.
/// With no others it is the object's silhouette, as if nothing stood in front. Solids are seen from outside: a ray that
/// begins inside one leaves it unhindered.
int visible_pixels(const CameraIntrinsics& camera, const Eye& eye, std::span<const scene::Solid> object,
                   std::span<const scene::Solid> others);

}  // namespace threewe::task
