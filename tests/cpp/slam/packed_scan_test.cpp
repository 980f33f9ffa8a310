// Scans in a quarter of the memory: what comes out is what went in, as nearly as is said.
#include "slam/packed_scan.hpp"

#include <doctest/doctest.h>

#include <vector>

#include "core/exact.hpp"
#include "draw.hpp"

namespace threewe::slam {
namespace {

TEST_CASE("beams come out as they went in, seen from anywhere") {
  for (std::uint64_t seed = 0; seed < cases(300); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    const Vec2 lidar = draw.point(-0.5, 0.5);
    std::vector<map::Beam> beams;
    for (int i = 0; i < 90; ++i) {
      const double angle = i == 0 ? exact::kPi : draw(-4.0, 4.0);
      const bool hit = draw(0.0, 1.0) < 0.7;
      beams.push_back({lidar + draw.point(-0.2, 0.2), rotate({1.0, 0.0}, angle),
                       static_cast<double>(static_cast<float>(draw(0.1, 30.0))), hit, hit && draw(0.0, 1.0) < 0.3});
    }
    const Pose2D frame_from_base = draw.pose(-50.0, 50.0);
    const std::vector<map::Beam> again = unpacked(packed(beams), frame_from_base);
    REQUIRE(again.size() == beams.size());
    for (std::size_t i = 0; i < beams.size(); ++i) {
      CHECK(distance(again[i].origin, frame_from_base * beams[i].origin) < 1e-4);
      CHECK(distance(again[i].direction, rotate(beams[i].direction, frame_from_base.theta)) < 5e-5);
      CHECK(norm(again[i].direction) == doctest::Approx(1.0).epsilon(1e-14));
      CHECK(again[i].range == beams[i].range);
      CHECK(again[i].hit == beams[i].hit);
      CHECK(again[i].thin == beams[i].thin);
    }
  }
  CHECK(unpacked(packed({}), {}).empty());
}

TEST_CASE("packing what was unpacked changes nothing") {
  for (std::uint64_t seed = 0; seed < cases(100); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    PackedScan scan{draw.point(-1.0, 1.0), {{2.0F, 7, 0, 0, 1}}};
    for (int i = 0; i < 50; ++i) {
      scan.beams.push_back({static_cast<float>(draw(0.0, 30.0)), static_cast<std::uint16_t>(draw.whole(0, 65535)),
                            static_cast<std::int16_t>(draw.whole(-9000, 9000)),
                            static_cast<std::int16_t>(draw.whole(-9000, 9000)),
                            static_cast<std::uint16_t>(draw.whole(0, 1))});
    }
    CHECK(packed(unpacked(scan, {})) == scan);
  }
}

}  // namespace
}  // namespace threewe::slam
