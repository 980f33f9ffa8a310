#include "sim/shape_index.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "core/rng.hpp"

using namespace threewe;
using namespace threewe::sim;

namespace {

double distance_to(const scene::Segment& segment, Vec2 point) {
  double least = 1e9;
  for (int i = 0; i <= 1000; ++i)
    least = std::min(least, distance(point, segment.a + i / 1000.0 * (segment.b - segment.a)));
  return least;
}

}  // namespace

TEST_CASE("everything within reach is found, and little else") {
  constexpr double kReach = 0.3;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    CAPTURE(seed);
    const double cell = seed % 2 == 0 ? 0.25 : 1.0;
    const RngKey key{.seed = seed};
    scene::Slice slice;
    for (std::uint64_t i = 0; i < 20; ++i) {
      const Vec2 a{uniform(key, i, 0, -4.0, 4.0), uniform(key, i, 1, -4.0, 4.0)};
      slice.segments.push_back({a, a + Vec2{uniform(key, i, 2, -1.5, 1.5), uniform(key, i, 3, -1.5, 1.5)}, -1});
      slice.circles.push_back(
          {{uniform(key, i, 4, -4.0, 4.0), uniform(key, i, 5, -4.0, 4.0)}, uniform(key, i, 6, 0.0, 0.4), -1});
    }
    const ShapeIndex index(slice, kReach, cell);
    for (std::uint64_t i = 0; i < 300; ++i) {
      const Vec2 point{uniform(key, i, 7, -7.0, 7.0), uniform(key, i, 8, -7.0, 7.0)};
      const auto near = index.near(point);
      for (std::size_t shape = 0; shape < 40; ++shape) {
        const double away = shape < 20
                                ? distance_to(slice.segments[shape], point)
                                : distance(point, slice.circles[shape - 20].center) - slice.circles[shape - 20].radius;
        const bool found = std::ranges::find(near, shape) != near.end();
        if (away <= kReach) CHECK(found);
        if (away > kReach + 1.42 * cell) CHECK_FALSE(found);  // a cell's diagonal
      }
    }
  }
}

TEST_CASE("nothing is near where nothing stands, however far out") {
  CHECK(ShapeIndex().near({0.0, 0.0}).empty());
  const ShapeIndex index({{{{0.0, 0.0}, {1.0, 0.0}, -1}}, {}}, 0.2);
  for (const double far : {5.0, -5.0, 1e9, -1e9, 1e300, std::nan("")}) {
    CHECK(index.near({far, 0.0}).empty());
    CHECK(index.near({0.5, far}).empty());
  }
}
