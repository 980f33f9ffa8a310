// Pixels of an object, counted column by column, are those that a ray tracer counts one by one.
#include "task/sight.hpp"

#include <doctest/doctest.h>

#include <cstdlib>

#include "core/exact.hpp"
#include "draw.hpp"
#include "task/slow_sight.hpp"

namespace threewe::task {
namespace {

using scene::Solid;

std::vector<Solid> random_solids(Draw& draw, int count) {
  std::vector<Solid> solids;
  for (int i = 0; i < count; ++i) {
    const Pose2D pose = draw.pose(-1.5, 1.5);
    solids.push_back(draw.whole(0, 1) == 0 ? scene::make_box(pose, draw(0.02, 1.0), draw(0.02, 0.6))
                                           : scene::make_disc(pose.position(), draw(0.02, 0.4)));
    solids.back().z_min = draw.whole(0, 1) == 0 ? 0.0 : draw(0.0, 0.8);
    solids.back().z_max = solids.back().z_min + draw(0.02, 1.0);
  }
  return solids;
}

TEST_CASE("pixels agree with a ray tracer, with and without others in front") {
  std::uint64_t pixels = 0;
  for (std::uint64_t seed = 0; seed < cases(600); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    const CameraIntrinsics camera = make_intrinsics(64, 48, draw(0.6, 2.2));
    const Eye eye{draw.pose(-2.0, 2.0), draw(0.05, 1.0)};
    const std::vector<Solid> object = random_solids(draw, draw.whole(1, 5));
    const std::vector<Solid> others = random_solids(draw, draw.whole(0, 6));
    std::vector<Solid> all = object;
    all.insert(all.end(), others.begin(), others.end());

    const auto count = [&](const std::vector<int>& picture) {
      return std::ranges::count_if(picture, [&](int i) { return i >= 0 && i < static_cast<int>(object.size()); });
    };
    // a ray along an edge may be on either side of it
    const auto silhouette = count(slow_picture(camera, eye, object));
    const auto visible = count(slow_picture(camera, eye, all));
    CHECK(std::abs(visible_pixels(camera, eye, object, {}) - silhouette) <= 1);
    CHECK(std::abs(visible_pixels(camera, eye, object, others) - visible) <= 1);
    pixels += static_cast<std::uint64_t>(visible);
  }
  CHECK(pixels > cases(50'000));
}

TEST_CASE("a box one metre ahead has the pixels that geometry gives it") {
  // 0.5 m wide and 0.5 m high around the optical axis: at f = 320 px, 160 x 160 pixels
  Solid box = scene::make_box({1.1, 0.0, 0.0}, 0.2, 0.5);
  box.z_max = 0.5;
  const CameraIntrinsics camera = make_intrinsics(640, 480, 0.5 * exact::kPi);
  const Eye eye{{0.0, 0.0, 0.0}, 0.25};
  CHECK(visible_pixels(camera, eye, std::array{box}, {}) == 160 * 160);

  // behind a board that covers its left half, and all to the left
  Solid board = scene::make_box({0.5, 0.5, 0.0}, 0.02, 1.0);
  board.z_max = 1.0;
  CHECK(visible_pixels(camera, eye, std::array{box}, std::array{board}) == 80 * 160);
}

}  // namespace
}  // namespace threewe::task
