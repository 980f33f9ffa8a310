#include "perception/sonar_grid.hpp"

#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/rng.hpp"
#include "draw.hpp"

using namespace threewe;
using perception::SonarGrid;

namespace {

RangeData echo(double range) { return {0.2618, 0.02, 4.0, range}; }

std::int8_t at(const SonarGrid& map, Vec2 point) { return map.grid().at(map.grid().cell(point)); }
bool occupied(const SonarGrid& map, Vec2 point) { return at(map, point) >= map::OccupancyGrid::kOccupiedThreshold; }
bool free(const SonarGrid& map, Vec2 point) {
  return at(map, point) != map::OccupancyGrid::kUnknown && !occupied(map, point);
}

}  // namespace

TEST_CASE("an echo that others explain marks nothing, and tells what is free") {
  SonarGrid map;
  for (int i = 0; i < 3; ++i) map.update(echo(1.0), {}, true);
  CHECK(map.occupied_near({1.0, 0.0}, 0.5).empty());
  CHECK(free(map, {0.5, 0.0}));
  map.update(echo(1.0), {});
  CHECK_FALSE(map.occupied_near({1.0, 0.0}, 0.5).empty());
}

TEST_CASE("an echo stands somewhere on its arc, and nothing before it") {
  SonarGrid map;
  const Pose2D sensor{0.3, 0.2, 0.5};
  map.update(echo(1.0), sensor);
  for (const double bearing : {-0.13, -0.06, 0.0, 0.06, 0.13}) {
    CAPTURE(bearing);
    CHECK(occupied(map, sensor * rotate({1.0, 0.0}, bearing)));
  }
  for (const double range : {0.1, 0.4, 0.8}) CHECK(free(map, sensor * Vec2{range, 0.0}));
  CHECK(at(map, sensor * Vec2{1.2, 0.0}) == map::OccupancyGrid::kUnknown);
  CHECK(at(map, sensor * Vec2{0.5, 0.3}) == map::OccupancyGrid::kUnknown);
}

TEST_CASE("no echo tells nothing, and a far one only what is free") {
  SonarGrid map;
  map.update(echo(4.0), {});
  CHECK(map.version() == 0);
  map.update(echo(3.0), {});
  CHECK(free(map, {1.0, 0.0}));
  CHECK(map.occupied_near({}, 5.0).empty());
}

TEST_CASE("echoes from farther away unmake an obstacle") {
  SonarGrid map;
  map.update(echo(0.8), {});
  CHECK(occupied(map, {0.8, 0.0}));
  for (int i = 0; i < 3; ++i) map.update(echo(1.4), {});
  CHECK_FALSE(occupied(map, {0.8, 0.0}));
  CHECK(occupied(map, {1.4, 0.0}));
}

TEST_CASE("a bump stands just outside of the outline, on the side that the push came from") {
  const Footprint footprint = Footprint::rectangle(0.25, 0.22);
  const Pose2D robot{1.0, -2.0, 0.7};
  for (const Vec2 towards : {Vec2{1.0, 0.0}, Vec2{0.0, 1.0}, Vec2{-1.0, 0.0}, Vec2{0.0, -1.0}}) {
    SonarGrid map;
    CHECK_FALSE(map.detect_bump(-5.0 * towards, footprint, robot));  // wheels can do that
    CHECK(map.version() == 0);
    CHECK(map.detect_bump(-15.0 * towards, footprint, robot));
    const std::vector<Vec2> obstacles = map.occupied_near(robot.position(), 0.5);
    REQUIRE_FALSE(obstacles.empty());
    for (const Vec2 obstacle : obstacles) {
      const Vec2 in_base = inverse(robot) * obstacle;
      CHECK(dot(in_base, towards) > 0.08);
      CHECK(footprint.signed_distance(in_base) < 0.06);
      CHECK(footprint.signed_distance(in_base) > -0.03);  // a cell is 5 cm wide
    }
  }
}

TEST_CASE("what is occupied near a point, echo by echo, against looking at every cell") {
  for (std::uint64_t seed = 0; seed < cases(40); ++seed) {
    CAPTURE(seed);
    SonarGrid map;
    const RngKey key{.seed = seed};
    for (std::uint64_t i = 0; i < 60; ++i) {
      map.update(echo(uniform(key, i, 0, 0.1, 1.5)),
                 {uniform(key, i, 1, -2.0, 2.0), uniform(key, i, 2, -2.0, 2.0), uniform(key, i, 3, -3.0, 3.0)});
      const Vec2 point{uniform(key, i, 4, -4.0, 4.0), uniform(key, i, 5, -4.0, 4.0)};
      const double radius = uniform(key, i, 6, 0.0, 3.0);
      std::vector<Vec2> expected;
      for (int y = 0; y < map.grid().height; ++y) {
        for (int x = 0; x < map.grid().width; ++x) {
          const Vec2 center = map.grid().center({x, y});
          if (occupied(map, center) && distance(center, point) <= radius) expected.push_back(center);
        }
      }
      REQUIRE(map.occupied_near(point, radius) == expected);
    }
  }
}
