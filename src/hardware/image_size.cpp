#include "threewe/hardware/profile.hpp"

namespace threewe {

RobotProfile with_image_size(RobotProfile profile, const ImageSize& size) {
  if (!profile.camera) return profile;
  check(make_intrinsics(size.width, size.height, profile.camera->horizontal_fov));
  profile.camera->width = size.width;
  profile.camera->height = size.height;
  return profile;
}

}  // namespace threewe
