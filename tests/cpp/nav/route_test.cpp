// Routes to frontiers, in a map whose truth each test knows.
#include "nav/route.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <optional>
#include <vector>

#include "core/exact.hpp"
#include "nav/polyline.hpp"
#include "threewe/map/occupancy_grid.hpp"

namespace threewe::nav {
namespace {

using map::OccupancyGrid;

void fill(OccupancyGrid& grid, Vec2 low, Vec2 high, std::int8_t value) {
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const Vec2 p = grid.center({x, y});
      if (p.x > low.x && p.x < high.x && p.y > low.y && p.y < high.y) grid.data[grid.index({x, y})] = value;
    }
  }
}

// A hall of 12 x 4 m. Its east end has not been seen, nor has most of the closet in its north-west, behind a slit of
// 0.4 m at (2, 2.5) through which the robot would just fit.
OccupancyGrid hall() {
  OccupancyGrid grid{240, 80, 0.05, {0.0, 0.0}, std::vector<std::int8_t>(19'200, OccupancyGrid::kOccupied)};
  fill(grid, {0.1, 0.1}, {10.5, 3.9}, OccupancyGrid::kFree);
  fill(grid, {10.5, 0.1}, {11.9, 3.9}, OccupancyGrid::kUnknown);
  fill(grid, {0.1, 2.45}, {4.0, 2.55}, OccupancyGrid::kOccupied);
  fill(grid, {3.9, 2.5}, {4.0, 3.9}, OccupancyGrid::kOccupied);
  fill(grid, {0.1, 3.1}, {3.9, 3.9}, OccupancyGrid::kUnknown);
  fill(grid, {1.8, 2.45}, {2.2, 2.55}, OccupancyGrid::kFree);
  return grid;
}

// A robot that drives to frontiers, a step between plans.
struct Explorer {
  OccupancyGrid grid = hall();
  std::uint64_t version = 1;
  Route route{
      {.lethal_radius = 0.13, .caution_radius = 0.4, .near_weight = 16}, load_profile("3we_standard_v2"), Params{}};
  Vec2 here{2.0, 1.2};
  Time now{};
  int changes_of_mind = 0;
  std::optional<Vec2> bound_for;

  Explorer() { route.begin({}, false); }

  // False: nothing is left that can be reached.
  bool plan(const std::vector<Vec2>& obstacles) {
    now += 600ms;
    slam::PoseEstimate pose;
    pose.odom_from_base = {here.x, here.y, 0.0};
    return route.plan_to_frontier({now, pose, grid, version, obstacles}, {.thorough = true});
  }
  bool step(const std::vector<Vec2>& obstacles) {
    if (!plan(obstacles)) return false;
    const Vec2 end = route.path().back();
    if (bound_for && distance(*bound_for, end) > 2.0) ++changes_of_mind;
    bound_for = end;
    const Vec2 next = route.path()[1];
    const double share = std::min(1.0, 0.2 / std::max(distance(here, next), 1e-6));
    here = here + share * (next - here);
    route.advance(here);
    if (here.x > 9.5) fill(grid, {10.5, 0.1}, {11.9, 3.9}, OccupancyGrid::kFree), ++version;
    return true;
  }
  bool has_seen_the_east() const { return grid.at(grid.cell({11.0, 2.0})) == OccupancyGrid::kFree; }
};

TEST_CASE("a slit that looks open from afar and is not keeps no robot from the rest") {
  Explorer explorer;
  const Vec2 slit{2.0, 2.5};
  int steps = 0;
  const auto obstacles = [&] {
    return distance(explorer.here, slit) < 1.0 ? std::vector<Vec2>{slit} : std::vector<Vec2>{};
  };
  while (steps < 600 && explorer.step(obstacles())) ++steps;
  CHECK(explorer.has_seen_the_east());
  CHECK(explorer.changes_of_mind < 10);
  CHECK(steps < 400);  // and it says itself that it is done
}

TEST_CASE("what was avoided is tried again before an exploration ends") {
  Explorer explorer;
  // it got stuck on its way east, where the hall is narrow: the place is avoided, and there is no other way
  fill(explorer.grid, {6.0, 0.1}, {6.1, 1.8}, OccupancyGrid::kOccupied);
  fill(explorer.grid, {6.0, 2.2}, {6.1, 3.9}, OccupancyGrid::kOccupied);
  fill(explorer.grid, {1.8, 2.45}, {2.2, 2.55}, OccupancyGrid::kOccupied);
  int steps = 0;
  while (steps < 600 && explorer.step({}) && explorer.here.x < 5.85) ++steps;
  explorer.route.avoid_ahead(true);
  explorer.route.drop();
  while (steps < 600 && explorer.step({})) ++steps;
  CHECK(explorer.has_seen_the_east());
  CHECK(steps < 600);
}

TEST_CASE("where it has driven it is never barred, or it would call an end what is a trap of its own") {
  Explorer explorer;
  const auto put = [&](Vec2 low, Vec2 high, std::int8_t value) { fill(explorer.grid, low, high, value); };
  put({6.0, 0.1}, {6.1, 1.8}, OccupancyGrid::kOccupied);
  put({6.0, 2.2}, {6.1, 3.9}, OccupancyGrid::kOccupied);
  put({1.8, 2.45}, {2.2, 2.55}, OccupancyGrid::kOccupied);
  while (explorer.here.x < 6.3 && explorer.step({})) continue;
  REQUIRE(explorer.here.x >= 6.3);

  // it gets stuck on its way back, again and again
  put({10.5, 0.1}, {11.9, 3.9}, OccupancyGrid::kFree);
  put({0.1, 0.1}, {1.0, 2.45}, OccupancyGrid::kUnknown);
  ++explorer.version;
  for (int i = 0; i < 4; ++i) {
    REQUIRE(explorer.plan({}));
    explorer.route.avoid_ahead(false);
    explorer.route.drop();
  }
  int steps = 0;
  while (steps < 200 && explorer.here.x > 1.5 && explorer.step({})) ++steps;
  CHECK(explorer.here.x <= 1.5);
}

TEST_CASE("a place that is worth a way is explored before a nearer one that is not") {
  // both ends of the hall are unknown; the robot stands 2 m nearer to the west one
  OccupancyGrid grid = hall();
  fill(grid, {0.1, 0.1}, {11.9, 3.9}, OccupancyGrid::kFree);
  fill(grid, {0.1, 0.1}, {1.5, 3.9}, OccupancyGrid::kUnknown);
  fill(grid, {10.5, 0.1}, {11.9, 3.9}, OccupancyGrid::kUnknown);
  slam::PoseEstimate pose;
  pose.odom_from_base = {5.0, 2.0, 0.0};
  const auto end = [&](const Explore& goal) {
    Route route{
        {.lethal_radius = 0.13, .caution_radius = 0.4, .near_weight = 16}, load_profile("3we_standard_v2"), Params{}};
    route.begin({}, false);
    REQUIRE(route.plan_to_frontier({600ms, pose, grid, 1, {}}, goal));
    return route.path().back().x;
  };
  const auto east = [](double worth) { return [=](Vec2 place) { return place.x > 8.0 ? worth : 0.0; }; };
  CHECK(end({}) < 2.0);
  CHECK(end({.worth = east(1.0), .most_worth = 4.0}) < 2.0);
  CHECK(end({.worth = east(4.0), .most_worth = 4.0}) > 10.0);
  CHECK(end({.worth = east(1e9), .most_worth = 1.0}) < 2.0);  // no more than it may be
}

TEST_CASE("a slit as wide as the robot is passed only when there is no other way, and barred once it is too narrow") {
  // a closet behind a slit of three cells
  OccupancyGrid grid = hall();
  fill(grid, {0.1, 2.55}, {3.9, 3.9}, OccupancyGrid::kFree);
  fill(grid, {0.1, 2.45}, {4.0, 2.55}, OccupancyGrid::kOccupied);
  fill(grid, {1.9, 2.45}, {2.05, 2.55}, OccupancyGrid::kFree);
  Route route({.lethal_radius = 0.12, .caution_radius = 0.4, .near_weight = 16}, load_profile("3we_standard_v2"),
              Params{});
  slam::PoseEstimate pose;
  pose.odom_from_base = {1.0, 1.2, 0.0};
  const Observation seen{Time{}, pose, grid, 1, {}};

  route.begin({{3.0, 3.3}}, false);
  CHECK_FALSE(route.plan_to_goal(seen, 0.1));
  REQUIRE(route.plan_through_gaps(seen, 0.1));
  REQUIRE(route.bottleneck());
  const Pose2D middle = route.bottleneck()->map_from_middle;
  CHECK(distance(middle.position(), {1.975, 2.5}) < 0.1);
  CHECK(std::fabs(wrap_angle(middle.theta - 0.5 * exact::kPi)) < 0.8);

  route.close_bottleneck(true);
  CHECK_FALSE(route.has_path());
  CHECK_FALSE(route.plan_to_goal(seen, 0.1));
  CHECK_FALSE(route.plan_through_gaps(seen, 0.1));

  // the next motion knows nothing of that; and where a wall has a door, that is taken
  fill(grid, {3.0, 2.45}, {3.6, 2.55}, OccupancyGrid::kFree);
  route.begin({{3.0, 3.3}}, false);
  CHECK(route.plan_to_goal({Time{}, pose, grid, 2, {}}, 0.1));
  CHECK_FALSE(route.bottleneck());
}

TEST_CASE("a path that closes before the robot is worth a slit where the way round is long") {
  OccupancyGrid grid = hall();
  fill(grid, {0.1, 2.55}, {3.9, 3.9}, OccupancyGrid::kFree);
  fill(grid, {0.1, 2.45}, {4.0, 2.55}, OccupancyGrid::kOccupied);
  fill(grid, {0.3, 2.45}, {0.6, 2.55}, OccupancyGrid::kFree);
  fill(grid, {3.4, 2.45}, {3.9, 2.55}, OccupancyGrid::kFree);
  Route route({.lethal_radius = 0.12, .caution_radius = 0.4, .near_weight = 16}, load_profile("3we_standard_v2"),
              Params{});
  slam::PoseEstimate pose;
  pose.odom_from_base = {0.45, 1.9, 0.0};
  const Observation before{Time{}, pose, grid, 1, {}};
  route.begin({{0.45, 3.3}}, false);
  REQUIRE(route.plan_to_goal(before, 0.1));
  const double direct = path_length(route.path());
  CHECK_FALSE(route.plan_shortcut(before, 0.1, 1.0));

  // from near it is a slit of three cells
  OccupancyGrid closed = grid;
  fill(closed, {0.3, 2.45}, {0.45, 2.55}, OccupancyGrid::kOccupied);
  const Observation seen{Time{} + 1s, pose, closed, 2, {}};
  REQUIRE(route.plan_to_goal(seen, 0.1));
  const double round = path_length(route.path());
  CHECK(round > direct + 3.0);
  CHECK_FALSE(route.plan_shortcut(seen, 0.1, round));
  CHECK(path_length(route.path()) == round);
  REQUIRE(route.plan_shortcut(seen, 0.1, 2.0));
  CHECK(path_length(route.path()) < direct + 0.3);
  CHECK(route.bottleneck());

  // where nothing has closed, plans keep their distance
  route.begin({{0.45, 3.3}}, false);
  REQUIRE(route.plan_to_goal(seen, 0.1));
  CHECK_FALSE(route.plan_shortcut(seen, 0.1, 2.0));
  CHECK(path_length(route.path()) == round);
}

TEST_CASE("a gap in which the robot got stuck again and again counts as a bottleneck, once") {
  OccupancyGrid grid = hall();
  fill(grid, {0.1, 2.55}, {3.9, 3.9}, OccupancyGrid::kFree);
  fill(grid, {1.8, 2.45}, {2.1, 2.55}, OccupancyGrid::kFree);
  fill(grid, {2.1, 2.45}, {2.3, 2.55}, OccupancyGrid::kOccupied);
  Route route({.lethal_radius = 0.12, .caution_radius = 0.4, .near_weight = 16}, load_profile("3we_standard_v2"),
              Params{});
  slam::PoseEstimate pose;
  pose.odom_from_base = {1.95, 2.1, 0.0};
  const Observation seen{Time{}, pose, grid, 1, {}};
  route.begin({{1.95, 3.3}}, false);
  REQUIRE(route.plan_to_goal(seen, 0.1));
  CHECK_FALSE(route.bottleneck());
  CHECK(route.squeeze_ahead({1.95, 2.1}));
  route.drop();
  REQUIRE(route.plan_to_goal(seen, 0.1));
  REQUIRE(route.bottleneck());
  CHECK(distance(route.bottleneck()->map_from_middle.position(), {1.95, 2.5}) < 0.08);

  // seen from near it turned out to be wide: nothing special any more
  route.clear_bottleneck();
  REQUIRE(route.plan_to_goal(seen, 0.1));
  CHECK_FALSE(route.bottleneck());

  // what could not be passed is no bottleneck again
  CHECK(route.squeeze_ahead({1.95, 2.1}));
  REQUIRE(route.plan_to_goal(seen, 0.1));
  route.close_bottleneck(false);
  REQUIRE(route.plan_to_goal(seen, 0.1));
  CHECK_FALSE(route.bottleneck());
  CHECK_FALSE(route.squeeze_ahead({1.95, 2.1}));
}

}  // namespace
}  // namespace threewe::nav
