// Bins of directions against those of the arc tangent.
#include "perception/bearing_bin.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>

#include "core/exact.hpp"
#include "draw.hpp"

namespace threewe::perception {
namespace {

std::size_t by_arc_tangent(Vec2 d) {
  const double share = (exact::atan2(d.y, d.x) + exact::kPi) / (2.0 * exact::kPi);
  return static_cast<std::size_t>(std::floor(share * static_cast<double>(kBearingBins))) % kBearingBins;
}

TEST_CASE("the bin of a direction is that of its arc tangent, wherever the search begins") {
  for (std::uint64_t seed = 0; seed < cases(20'000); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    // every second one on a border between bins, or as near to it as numbers get
    const bool border = draw.whole(0, 1) == 1;
    const double angle =
        border ? draw.whole(-180, 180) * exact::kPi / 180.0 + draw.whole(-3, 3) * 4e-16 : draw(-exact::kPi, exact::kPi);
    const Vec2 d = rotate({draw(1e-6, 20.0), 0.0}, angle);
    const std::size_t expected = by_arc_tangent(d);
    REQUIRE(bearing_bin(d, static_cast<std::size_t>(draw.whole(0, 359))) == expected);
    REQUIRE(bearing_bin(d, (expected + static_cast<std::size_t>(draw.whole(357, 363))) % kBearingBins) == expected);
  }
}

TEST_CASE("axes and no direction at all have the bins of their arc tangents too") {
  for (const Vec2 d : {Vec2{1, 0}, Vec2{-1, 0}, Vec2{-1, -0.0}, Vec2{0, 1}, Vec2{0, -1}, Vec2{0, 0}}) {
    for (std::size_t near = 0; near < kBearingBins; ++near) CHECK(bearing_bin(d, near) == by_arc_tangent(d));
  }
}

}  // namespace
}  // namespace threewe::perception
