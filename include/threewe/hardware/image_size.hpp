// Pictures of another size than a robot's profile states.
#pragma once

#include "threewe/hardware/profile.hpp"

namespace threewe {

/// [px]
struct ImageSize {
  int width = 0;
  int height = 0;
};

/// The same robot, whose camera delivers pictures of another size: with the same horizontal field of view and square
/// pixels. A robot without a camera stays as it is. Throws ConfigError for a size that no picture has.
RobotProfile with_image_size(RobotProfile profile, const ImageSize& size);

}  // namespace threewe
