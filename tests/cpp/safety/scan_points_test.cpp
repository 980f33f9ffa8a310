#include "safety/scan_points.hpp"

#include <doctest/doctest.h>

#include "core/exact.hpp"
#include "core/rng.hpp"

using namespace threewe;
using namespace threewe::safety;

namespace {

// The same, beam by beam.
std::vector<Vec2> plain_points(const LidarSpec& lidar, std::span<const float> ranges, const Pose2D& base_at_begin,
                               const Pose2D& base_at_end, double longest) {
  std::vector<Vec2> points;
  const auto beams = static_cast<double>(ranges.size());
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const auto range = static_cast<double>(ranges[i]);
    if (range < lidar.range_min || range >= lidar.range_max || range > longest) continue;
    const double gone_by = (static_cast<double>(i) + 0.5) / beams;
    const double share = !lidar.rolling ? 1.0 : lidar.clockwise ? 1.0 - gone_by : gone_by;
    const Pose2D sensor =
        interpolate(base_at_begin * lidar.base_from_lidar, base_at_end * lidar.base_from_lidar, share);
    const double angle = sensor.theta - exact::kPi + static_cast<double>(i) * (2.0 * exact::kPi / beams);
    points.push_back(sensor.position() + range * rotate({1.0, 0.0}, angle));
  }
  return points;
}

}  // namespace

TEST_CASE("points are where single beams would put them, to the bit, whatever the turn and the number of beams") {
  const RngKey key{.seed = 5, .stream = Stream::sampler};
  for (std::uint64_t i = 0; i < 300; ++i) {
    CAPTURE(i);
    std::uint64_t draw = 1000 * i;
    const auto number = [&](double low, double high) { return uniform(key, draw++, 0, low, high); };
    const auto pose = [&] { return Pose2D{number(-20.0, 20.0), number(-20.0, 20.0), number(-3.14, 3.14)}; };
    LidarSpec lidar;
    lidar.range_min = 0.05;
    lidar.range_max = 12.0;
    lidar.rolling = number(0.0, 1.0) < 0.5;
    lidar.clockwise = number(0.0, 1.0) < 0.5;
    lidar.base_from_lidar = pose();
    std::vector<float> ranges(static_cast<std::size_t>(number(1.0, 1300.0)));
    for (float& range : ranges) range = static_cast<float>(number(-1.0, 14.0));
    const Pose2D begin = pose();
    const Pose2D end = pose();
    const double longest = number(0.0, 15.0);
    std::vector<Vec2> points{{1.0, 2.0}};  // what is there stays
    append_scan_points(lidar, ranges, begin * lidar.base_from_lidar, end * lidar.base_from_lidar, points, longest);
    REQUIRE(points.front() == Vec2{1.0, 2.0});
    points.erase(points.begin());
    CHECK(points == plain_points(lidar, ranges, begin, end, longest));
  }
}
