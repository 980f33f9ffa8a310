#include "agent/coverage.hpp"

#include <cstdlib>

#include <doctest/doctest.h>

using namespace threewe;
using agent::Coverage;
using agent::Reachable;

TEST_CASE("what is looked at next is the nearest that was not seen, or what is worth a longer way") {
  map::OccupancyGrid grid;
  grid.width = grid.height = 200;
  grid.origin = {-5.0, -5.0};
  grid.data.assign(40000, map::OccupancyGrid::kFree);
  const Reachable reachable(grid, {0.1, 0.1}, 0.2);
  REQUIRE(reachable.ways().size() == reachable.squares().size());
  for (std::size_t i = 0; i < reachable.squares().size(); ++i) {  // on free floor: along the axes
    const auto [x, y] = reachable.squares()[i];
    REQUIRE(reachable.ways()[i] == doctest::Approx(agent::kSquare * (std::abs(x) + std::abs(y))));
  }

  Coverage coverage;
  for (const agent::Square& square : reachable.squares()) coverage.add(square);
  const Vec2 near{-1.1, 0.1};
  const Vec2 far{3.1, 0.1};
  Coverage two;
  for (const agent::Square& square : reachable.squares()) {
    if (square != agent::square_of(near) && square != agent::square_of(far)) two.add(square);
  }
  CHECK_FALSE(coverage.next(grid, reachable, {}));
  const auto worth = [&](double metres) { return [metres](Vec2 point) { return point.x > 2.0 ? metres : 0.0; }; };
  CHECK(two.next(grid, reachable, {})->shows == agent::square_of(near));
  CHECK(two.next(grid, reachable, {}, worth(1.0))->shows == agent::square_of(near));
  CHECK(two.next(grid, reachable, {}, worth(4.0))->shows == agent::square_of(far));
  CHECK(two.next(grid, reachable, [](Vec2 point) { return point.x > 0.0; })->shows == agent::square_of(far));
}
