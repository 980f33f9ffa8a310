// Starts and goals for planners: in a furnished place of 200 m x 200 m, and in a window of it.
#pragma once

#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "furnished_place.hpp"
#include "map/costmap.hpp"
#include "nav/planner.hpp"

namespace threewe {

/// From where to where.
struct Journey {
  Vec2 from;
  Vec2 to;
};

/// A map, what it costs to be where in it, and journeys whose way has about the same length.
struct Course {
  map::OccupancyGrid grid;
  map::Costmap costmap;
  std::vector<Journey> journeys;

  /// `shortest`, `longest`: the way between start and goal [m], both of them well away from everything.
  Course(map::OccupancyGrid place, std::size_t count, double shortest, double longest) : grid(std::move(place)) {
    costmap.update(grid, {}, {});
    std::mt19937_64 bits(1);
    nav::Planner planner;
    const auto somewhere = [&] {
      for (;;) {
        const map::Cell c{static_cast<int>(bits() % static_cast<unsigned>(grid.width)),
                          static_cast<int>(bits() % static_cast<unsigned>(grid.height))};
        const Vec2 p = grid.center(c);
        if (costmap.weight(costmap.cell(p)) == map::Costmap::kFree) return p;
      }
    };
    while (journeys.size() < count) {
      const Vec2 from = somewhere();
      const Vec2 to = somewhere();
      if (distance(from, to) > longest || distance(from, to) < 0.5 * shortest) continue;
      const double length = nav::path_length(planner.plan(costmap, from, to, 0.25).points);
      if (length >= shortest && length <= longest) journeys.push_back({from, to});
    }
  }
};

/// 100 ways of 70 to 80 m through furnished buildings.
inline Course campus() { return {FurnishedPlace().grid, 100, 70.0, 80.0}; }

/// Ways of 8 to 12 m within 16 m x 16 m of the same, with a wall around it.
inline Course campus_window(std::size_t count) {
  constexpr int kSide = 320;     // [cells of 5 cm]
  constexpr int kCorner = 2040;  // in the middle building
  const FurnishedPlace place;
  map::OccupancyGrid window;
  window.width = window.height = kSide;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const bool rim = x == 0 || y == 0 || x == kSide - 1 || y == kSide - 1;
      window.data.push_back(rim ? map::OccupancyGrid::kOccupied : place.grid.at({kCorner + x, kCorner + y}));
    }
  }
  return {std::move(window), count, 8.0, 12.0};
}

}  // namespace threewe
