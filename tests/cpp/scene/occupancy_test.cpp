// Grids of a scene agree with a search through all solids and all cells.
#include "scene/occupancy.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <limits>

#include "core/exact.hpp"
#include "draw.hpp"
#include "scene/random_solids.hpp"

namespace threewe::scene {
namespace {

const GridFrame kFrame{{-2.0, -1.5}, 0.05, 80, 60};

std::vector<Vec2> square(const GridFrame& frame, CellIndex cell) {
  const Vec2 c = frame.center(cell);
  const double h = 0.5 * frame.resolution;
  return {{c.x - h, c.y - h}, {c.x + h, c.y - h}, {c.x + h, c.y + h}, {c.x - h, c.y + h}};
}

TEST_CASE("points and cells convert into each other, far outside as well") {
  CHECK(kFrame.cell(Vec2{-2.0, -1.5}) == CellIndex{0, 0});
  CHECK(kFrame.cell(Vec2{-1.949, -1.5}) == CellIndex{1, 0});
  CHECK_FALSE(kFrame.contains(kFrame.cell(Vec2{1e300, 0.0})));
  CHECK_FALSE(kFrame.contains(kFrame.cell(Vec2{0.0, -1e300})));
  for (std::size_t i = 0; i < kFrame.size(); ++i) {
    CHECK(kFrame.index(kFrame.cell(i)) == i);
    CHECK(kFrame.cell(kFrame.center(kFrame.cell(i))) == kFrame.cell(i));
  }
}

TEST_CASE("a cell is occupied when a solid holds a point of it, and only when one overlaps its square") {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    CAPTURE(seed);
    Dice dice(seed);
    std::vector<Solid> solids = random_solids(dice, 8, 2.0);
    for (const double theta : {0.0, 0.5 * exact::kPi, exact::kPi, -0.5 * exact::kPi}) {
      solids.push_back(
          make_box({dice.in(-2.0, 2.0), dice.in(-1.5, 1.5), theta}, dice.in(0.02, 1.5), dice.in(0.02, 0.8)));
    }
    const CellSet occupied = occupied_cells(kFrame, solids);
    for (std::size_t i = 0; i < kFrame.size(); ++i) {
      const CellIndex cell = kFrame.cell(i);
      const std::vector<Vec2> corners = square(kFrame, cell);
      const bool overlap = std::ranges::any_of(solids, [&](const Solid& s) { return overlaps(s, corners); });
      CHECK((occupied.cells[i] != 0) == overlap);
      if (std::ranges::any_of(solids, [&](const Solid& s) { return holds(s, kFrame.center(cell)); }))
        CHECK(occupied.cells[i]);
    }
  }
}

TEST_CASE("the distance field is the distance to the nearest of all cells") {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    CAPTURE(seed);
    Dice dice(seed);
    const GridFrame frame{{0.0, 0.0}, 0.05, 37, 23};
    CellSet set(frame, 0);
    std::vector<CellIndex> members;
    for (int i = 0; i < static_cast<int>(seed) * 3; ++i) {
      const CellIndex cell{static_cast<int>(dice.in(0, frame.width)), static_cast<int>(dice.in(0, frame.height))};
      set[cell] = 1;
      members.push_back(cell);
    }
    const CellGrid<float> distances = distance_field(set);
    for (std::size_t i = 0; i < frame.size(); ++i) {
      double nearest = std::numeric_limits<double>::infinity();
      for (const CellIndex m : members)
        nearest = std::min(nearest, distance(frame.center(m), frame.center(frame.cell(i))));
      if (members.empty()) {
        CHECK(distances.cells[i] == std::numeric_limits<float>::infinity());
      } else {
        CHECK(static_cast<double>(distances.cells[i]) == doctest::Approx(nearest).epsilon(1e-6));
      }
    }
  }
}

TEST_CASE("cells with clearance are those whose middle is far enough from every solid") {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    CAPTURE(seed);
    Dice dice(seed);
    const Obstacles obstacles(random_solids(dice, 6, 1.5));
    const double radius = dice.in(0.05, 0.4);
    const CellSet clear =
        cells_with_clearance(obstacles, distance_field(occupied_cells(kFrame, obstacles.solids())), radius);
    for (std::size_t i = 0; i < kFrame.size(); ++i) {
      double nearest = std::numeric_limits<double>::infinity();
      for (const Solid& s : obstacles.solids())
        nearest = std::min(nearest, distance_to(s, kFrame.center(kFrame.cell(i))));
      CHECK((clear.cells[i] != 0) == (nearest >= radius));
    }
  }
}

// The slow way: cells next to connected ones are connected, again and again.
CellSet grown(const CellSet& set, CellIndex seed) {
  CellSet connected(set.frame, 0);
  if (set.value_or(seed, 0) != 0) connected[seed] = 1;
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < set.cells.size(); ++i) {
      const CellIndex c = set.frame.cell(i);
      if (!set.cells[i] || connected.cells[i]) continue;
      for (const CellIndex n : {CellIndex{c.x + 1, c.y}, {c.x - 1, c.y}, {c.x, c.y + 1}, {c.x, c.y - 1}}) {
        if (!connected.value_or(n, 0)) continue;
        connected.cells[i] = 1;
        changed = true;
        break;
      }
    }
  }
  return connected;
}

TEST_CASE("connected cells are those that grow from the seed") {
  for (std::uint64_t seed = 0; seed < cases(300); ++seed) {
    CAPTURE(seed);
    const RngKey key{.seed = seed, .stream = Stream::sampler};
    CellSet set({{0.0, 0.0}, 1.0, 3 + static_cast<int>(seed % 17), 2 + static_cast<int>(seed % 11)}, 0);
    for (std::size_t i = 0; i < set.cells.size(); ++i) set.cells[i] = uniform(key, i) < 0.65 ? 1 : 0;
    const CellIndex start{set.frame.width / 2, set.frame.height / 2};
    CHECK(connected_cells(set, set.frame.center(start)) == grown(set, start));
  }
}

TEST_CASE("connected cells stop at a wall and do not slip through a corner") {
  CellSet set({{0.0, 0.0}, 1.0, 4, 2}, 0);
  for (const CellIndex c : {CellIndex{0, 0}, {1, 0}, {2, 1}, {3, 1}}) set[c] = 1;
  const CellSet connected = connected_cells(set, {0.5, 0.5});
  CHECK(connected.cells == std::vector<unsigned char>{1, 1, 0, 0, 0, 0, 0, 0});
  CHECK(connected_cells(set, {0.5, 1.5}).cells == std::vector<unsigned char>(8, 0));
  CHECK(connected_cells(set, {-5.0, 0.0}).cells == std::vector<unsigned char>(8, 0));
}

}  // namespace
}  // namespace threewe::scene
