#include "threewe/core/camera.hpp"

#include <doctest/doctest.h>

#include <cmath>

#include "threewe/core/errors.hpp"

namespace threewe {
namespace {

TEST_CASE("the outermost columns see as far aside as the field of view says") {
  for (const double fov : {0.2, 1.2, 2.5}) {
    const CameraIntrinsics camera = make_intrinsics(640, 480, fov);
    CHECK(std::atan2(camera.cx, camera.fx) == doctest::Approx(0.5 * fov));
    CHECK(std::atan2(camera.width - camera.cx, camera.fx) == doctest::Approx(0.5 * fov));
    CHECK(camera.fy == camera.fx);
    CHECK(camera.cy == 240.0);
    CHECK_NOTHROW(check(camera));
  }
}

TEST_CASE("the largest image is 2^26 pixels") {
  CHECK_NOTHROW(check({16384, 4096, 100.0, 100.0, 0.0, 0.0}));
  CHECK_THROWS_WITH_AS(
      check({16384, 4097, 100.0, 100.0, 0.0, 0.0}),
      "a camera image of 16384 x 4097 pixels: sides must be 1 to 16384, and at most 67108864 pixels in all",
      ConfigError);
}

}  // namespace
}  // namespace threewe
