// What scans tell of their own scatter, in drawn rooms whose lidar's scatter is known.
#include "slam/range_noise_estimator.hpp"

#include <doctest/doctest.h>

#include <vector>

#include "core/exact.hpp"
#include "draw.hpp"
#include "slam/tiny_world.hpp"

namespace threewe::slam {
namespace {

using testing::add_box;
using testing::tiny_range;
using testing::TinyWall;

constexpr double kRangeMax = 12.0;
constexpr int kBeams = 360;

// A room of some shape and size, not along the axes, in which boxes stand.
std::vector<TinyWall> random_room(Draw& draw) {
  std::vector<TinyWall> walls;
  add_box(walls, {-draw(1.2, 8.0), -draw(1.2, 8.0)}, {draw(1.2, 8.0), draw(1.2, 8.0)});
  for (int i = draw.whole(0, 8); i > 0; --i) {
    const Vec2 low = rotate({draw(0.6, 4.0), 0.0}, draw(-3.0, 3.0));
    add_box(walls, low, low + Vec2{draw(0.1, 0.9), draw(0.1, 0.9)});
  }
  const double turn = draw(-3.0, 3.0);
  for (TinyWall& w : walls) w = {rotate(w.a, turn), rotate(w.b, turn)};
  return walls;
}

// What a lidar sees that is off by `sigma` and too long by `bias`, and loses a share of its beams.
LaserScan look(const std::vector<TinyWall>& walls, const Pose2D& pose, double sigma, double bias, double lost,
               Draw& draw) {
  const RngKey key{static_cast<std::uint64_t>(draw.whole(0, 1 << 30)), 0, 0, 0, Stream::lidar};
  LaserScan scan{-exact::kPi, 2.0 * exact::kPi / kBeams, 0.0, 0.02, kRangeMax, {}};
  for (int i = 0; i < kBeams; ++i) {
    const double angle = pose.theta + scan.angle_min + i * scan.angle_increment;
    const double range = tiny_range(walls, pose.position(), angle, kRangeMax);
    const double measured =
        range < kRangeMax ? range + bias + sigma * normal(key, static_cast<std::uint64_t>(i)) : kRangeMax;
    scan.ranges.push_back(draw(0.0, 1.0) < lost ? 0.0F : static_cast<float>(measured));
  }
  return scan;
}

TEST_CASE("the scatter of a lidar is found to a seventh, whatever was expected and wherever it is") {
  for (std::uint64_t seed = 0; seed < cases(500); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    const std::vector<TinyWall> walls = random_room(draw);
    const double sigma = draw(0.005, 0.05);
    const double bias = draw(-0.1, 0.1);
    const double lost = draw(0.0, 0.15);
    RangeNoiseEstimator scatter(draw(0.003, 0.03));
    for (int i = 0; i < 200; ++i) {
      scatter.add(look(walls, {0.002 * i, 0.0, 0.01 * i}, sigma, bias, lost, draw));
    }
    CAPTURE(sigma);
    CHECK(scatter.sigma() > 0.86 * sigma);
    CHECK(scatter.sigma() < 1.15 * sigma);
  }
}

}  // namespace
}  // namespace threewe::slam
