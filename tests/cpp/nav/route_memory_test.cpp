// What a route remembers of places, and what it makes of that.
#include "nav/route_memory.hpp"

#include <doctest/doctest.h>

#include <vector>

namespace threewe::nav {
namespace {

constexpr Vec2 kDoor{2.0, 1.0};
constexpr Vec2 kNearIt{2.0, 1.3};     // the same place
constexpr Vec2 kElsewhere{5.0, 1.0};  // another one

TEST_CASE("a place fails often when it has failed so many times, near enough to each other") {
  const Params params;
  RouteMemory memory(params);
  for (int i = 0; i < params.route.attempts; ++i) {
    CHECK_FALSE(memory.failed_often(kDoor));
    memory.avoid(Outcome::failed, i % 2 == 0 ? kDoor : kNearIt);
    memory.avoid(Outcome::excused, kElsewhere);
  }
  CHECK(memory.failed_often(kDoor));
  CHECK_FALSE(memory.failed_often(kElsewhere));

  // who stops avoiding it does not forget that
  memory.stop_avoiding();
  CHECK_FALSE(memory.avoids_any());
  CHECK(memory.failed_often(kDoor));
  memory.clear();
  CHECK_FALSE(memory.failed_often(kDoor));
}

TEST_CASE("plans avoid what has failed until they have to, and what is barred for good") {
  RouteMemory memory{Params{}};
  memory.note(Outcome::barred, kElsewhere);
  memory.avoid(Outcome::failed, kDoor);
  memory.note(Outcome::closed, kDoor);
  CHECK(memory.obstacles() == std::vector<Vec2>{kElsewhere, kDoor});
  memory.stop_avoiding(kNearIt);
  CHECK(memory.obstacles() == std::vector<Vec2>{kElsewhere});
}

TEST_CASE("what is suspended is avoided again when it is resumed, and no more when it never is") {
  RouteMemory memory{Params{}};
  for (int i = 0; i < Params{}.route.attempts; ++i) memory.avoid(Outcome::failed, kDoor);
  memory.avoid(Outcome::failed, kElsewhere);
  const std::vector<Vec2> all = memory.obstacles();
  memory.suspend_avoiding();
  CHECK(memory.obstacles() == std::vector<Vec2>(all.begin(), all.end() - 1));
  memory.resume_avoiding();
  CHECK(memory.obstacles() == all);

  memory.suspend_avoiding();
  memory.suspend_avoiding();
  memory.resume_avoiding();
  CHECK(memory.obstacles().size() == all.size() - 1);
}

TEST_CASE("bottlenecks are what was last made of them") {
  RouteMemory memory{Params{}};
  CHECK_FALSE(memory.tried_until(kDoor));
  memory.note_tried(kDoor, 90s);
  CHECK(memory.tried_until(kNearIt) == Time(90s));
  CHECK_FALSE(memory.tried_until(kElsewhere));
  memory.note(Outcome::stuck, kDoor);
  CHECK(memory.has(Outcome::stuck, kNearIt));
  memory.forget(Outcome::stuck, kNearIt);
  CHECK_FALSE(memory.has(Outcome::stuck));
  CHECK(memory.has(Outcome::tried));
}

TEST_CASE("who moved may have gone on to where it was free, as far as it could by now") {
  RouteMemory memory{Params{}};
  const std::vector<Vec2> free = {{1.5, 0.0}};
  for (int i = 0; i < 5; ++i) memory.note_mover({"robot 1", {0.3 * i, 0.0}, 0.2, i * 1s, free});
  memory.note_mover({"robot 2", {0.0, 5.0}, 0.2, 4s, free});
  const auto radius = [&](const std::string& name, Vec2 place, Time now) {
    const std::vector<Mover> movers = gone_on(memory.movers(), now, 0.04);
    const Mover* mover = mover_near(place, movers, 0.0);
    REQUIRE(mover != nullptr);
    CHECK(mover->name == name);
    return mover->radius + mover->gone_on;
  };
  CHECK(radius("robot 1", {1.2, 0.0}, 9s) == doctest::Approx(0.4));
  CHECK(radius("robot 1", {1.2, 0.0}, 900s) == doctest::Approx(0.6));
  CHECK(radius("robot 1", {0.0, 0.0}, 9s) == doctest::Approx(0.2));
  CHECK(radius("robot 2", {0.0, 5.0}, 9s) == doctest::Approx(0.4));
}

// A wall beside the way of a person, who may since have gone on to the free side only.
TEST_CASE("a mover is erased from where it was free, and no wall next to it is") {
  map::OccupancyGrid grid;
  grid.width = grid.height = 60;
  grid.data.assign(3600, map::OccupancyGrid::kFree);
  const auto fill = [&](int x, int y) { grid.data[grid.index({x, y})] = map::OccupancyGrid::kOccupied; };
  for (int y = 0; y < 60; ++y) fill(38, y);
  std::vector<Mover> movers = {{"person", {1.3, 1.5}, 0.3, 0s, free_cells_near(grid, {1.3, 1.5}, 0.9)}};
  for (int y = 35; y < 42; ++y) {
    for (int x = 24; x < 30; ++x) fill(x, y);  // where it stands now, half a metre on
  }
  movers = gone_on(movers, 60s, 0.05);
  erase_movers(grid, movers, 0.1);
  for (int y = 0; y < 60; ++y) CHECK(grid.data[grid.index({38, y})] == map::OccupancyGrid::kOccupied);
  CHECK(grid.data[grid.index({26, 38})] == map::OccupancyGrid::kFree);
}

TEST_CASE("where it has driven is remembered from place to place, not from tick to tick") {
  RouteMemory memory{Params{}};
  for (int tick = 0; tick <= 100; ++tick) memory.note_driven({0.01 * tick, 0.0});
  CHECK(memory.places(Outcome::driven).size() < 12);
  CHECK(memory.has_driven({0.55, 0.1}));
  CHECK_FALSE(memory.has_driven({0.55, 0.4}));
}

}  // namespace
}  // namespace threewe::nav
