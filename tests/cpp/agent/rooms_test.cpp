#include "agent/rooms.hpp"

#include <doctest/doctest.h>

using namespace threewe;
using agent::border_of;
using map::OccupancyGrid;
using semantics::Place;

namespace {

// Two rooms of 4 x 4 m west and east of x = 4, a corridor of 8 x 2 m to the north of both, without a wall to the east
// one:
//
//     |     corridor     |
//     --- D ---
//     |  west  D  east   |
std::vector<Place> rooms() {
  return {{.name = "west", .polygon = {{0, 0}, {4, 0}, {4, 4}, {0, 4}}},
          {.name = "east", .polygon = {{4, 4}, {8, 4}, {8, 0}, {4, 0}}},  // the other way round
          {.name = "corridor", .polygon = {{0, 4}, {8, 4}, {8, 6}, {0, 6}}},
          {.name = "dock", .polygon = {{1, 1}}}};
}

void fill(OccupancyGrid& grid, Vec2 low, Vec2 high, std::int8_t value) {
  for (double x = low.x + 0.025; x < high.x; x += grid.resolution) {
    for (double y = low.y + 0.025; y < high.y; y += grid.resolution) grid.data[grid.index(grid.cell({x, y}))] = value;
  }
}

OccupancyGrid house() {
  OccupancyGrid grid;
  grid.width = 180;
  grid.height = 140;
  grid.origin = {-0.5, -0.5};
  grid.data.assign(static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height), 4);  // free in SLAM
  fill(grid, {3.95, 0.0}, {4.05, 4.0}, 100);
  fill(grid, {3.95, 1.0}, {4.05, 2.0}, 4);  // a door
  fill(grid, {0.0, 3.95}, {4.0, 4.05}, 100);
  fill(grid, {1.0, 3.95}, {1.9, 4.05}, 4);  // another
  return grid;
}

}  // namespace

TEST_CASE("doors and open borders of a room are found where the map is free") {
  const auto places = rooms();
  const auto west = border_of(house(), places, 0);
  REQUIRE(west.openings.size() == 2);
  CHECK(west.unseen.empty());
  for (const agent::Opening& o : west.openings) {
    CHECK(o.is_door);
    const bool east = places[o.to].name == "east";
    CHECK(norm(o.normal - (east ? Vec2{1, 0} : Vec2{0, 1})) < 1e-9);
    CHECK(norm(o.middle() - (east ? Vec2{4.0, 1.5} : Vec2{1.45, 4.0})) < 0.1);
    CHECK(distance(o.a, o.b) == doctest::Approx(east ? 1.0 : 0.9).epsilon(0.15));
  }
  const auto east = border_of(house(), places, 1);
  REQUIRE(east.openings.size() == 2);
  for (const agent::Opening& o : east.openings) CHECK(o.is_door == (places[o.to].name == "west"));
}

TEST_CASE("what no beam has crossed is neither open nor a wall") {
  OccupancyGrid grid = house();
  fill(grid, {3.9, 1.0}, {4.1, 2.0}, OccupancyGrid::kUnknown);
  const auto border = border_of(grid, rooms(), 0);
  CHECK(border.openings.size() == 1);
  CHECK(border.unseen.size() >= 3);
  for (const auto& unseen : border.unseen) {
    CHECK(unseen.to == 1);
    CHECK(unseen.point.x == doctest::Approx(4.0));
    CHECK((unseen.point.y > 0.9 && unseen.point.y < 2.1));
  }
}

TEST_CASE("openings are crossed straight on, but not at their ends") {
  const agent::Opening wide{.is_door = false, .to = 1, .a = {0, 0}, .b = {3, 0}, .normal = {0, 1}};
  CHECK(norm(wide.crossing({1.2, -2.0}) - Vec2{1.2, 0}) < 1e-9);
  CHECK(norm(wide.crossing({-5.0, -2.0}) - Vec2{0.4, 0}) < 1e-9);
  const agent::Opening narrow{.is_door = true, .to = 1, .a = {0, 0}, .b = {0.6, 0}, .normal = {0, 1}};
  CHECK(norm(narrow.crossing({-5.0, -2.0}) - Vec2{0.3, 0}) < 1e-9);
}

TEST_CASE("rooms and their directions") {
  const auto places = rooms();
  CHECK(agent::room_at(places, {1, 1}) == 0);
  CHECK(agent::room_at(places, {5, 5}) == 2);
  CHECK_FALSE(agent::room_at(places, {-1, 1}));
  CHECK(norm(agent::along_walls(places[2], {0.9, 0.5}) - Vec2{1, 0}) < 1e-9);
  CHECK(norm(agent::along_walls(places[2], {0.3, -0.9}) - Vec2{0, -1}) < 1e-9);
}
