// Walking along a line visits the cells that it crosses, one beside the other.
#include "threewe/scene/cell_grid.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <vector>

#include "draw.hpp"
#include "scene/cell_lines.hpp"
#include "scene/random_solids.hpp"

namespace threewe::scene {
namespace {

const GridFrame kFrame{{-1.0, -2.0}, 0.1, 30, 40};

struct Line {
  Vec2 a, b;
};

// Within the grid; some along an axis, some short, some a point.
Line random_line(std::uint64_t seed) {
  Dice dice(seed);
  const Vec2 a{dice.in(-1.0, 2.0), dice.in(-2.0, 2.0)};
  Vec2 b{dice.in(-1.0, 2.0), dice.in(-2.0, 2.0)};
  if (seed % 10 == 0) b.x = a.x;
  if (seed % 10 == 1) b.y = a.y;
  if (seed % 10 == 2) b = a + 0.01 * (b - a);
  if (seed % 100 == 3) b = a;
  return {a, b};
}

std::vector<CellIndex> walked(Vec2 a, Vec2 b) {
  std::vector<CellIndex> cells;
  walk_line(kFrame, a, b, [&](CellIndex cell) {
    cells.push_back(cell);
    return true;
  });
  return cells;
}

// The length of the part of a line that lies in a cell, by clipping it to the cell's square; negative for a miss.
double length_inside(CellIndex cell, Vec2 a, Vec2 b) {
  const Vec2 c = kFrame.center(cell);
  const double h = 0.5 * kFrame.resolution;
  double from = 0.0;
  double to = 1.0;
  for (const auto& [start, slope, low] : {std::array{a.x, b.x - a.x, c.x - h}, std::array{a.y, b.y - a.y, c.y - h}}) {
    if (slope == 0.0) {
      if (start < low || start > low + 2.0 * h) return -1.0;
      continue;
    }
    const double enter = (low - start) / slope;
    const double leave = (low + 2.0 * h - start) / slope;
    from = std::max(from, std::min(enter, leave));
    to = std::min(to, std::max(enter, leave));
  }
  return (to - from) * distance(a, b);
}

TEST_CASE("every cell that a line crosses is visited once, in order, and no other") {
  for (std::uint64_t seed = 0; seed < cases(2000); ++seed) {
    CAPTURE(seed);
    const auto [a, b] = random_line(seed);
    const std::vector<CellIndex> cells = walked(a, b);
    CHECK(cells.front() == kFrame.cell(a));
    CHECK(cells.back() == kFrame.cell(b));
    CellSet visited(kFrame, 0);
    for (std::size_t i = 0; i < cells.size(); ++i) {
      CHECK(length_inside(cells[i], a, b) >= -1e-9);
      CHECK_FALSE(visited[cells[i]]);
      visited[cells[i]] = 1;
      if (i > 0) CHECK(std::abs(cells[i].x - cells[i - 1].x) + std::abs(cells[i].y - cells[i - 1].y) == 1);
    }
    for (std::size_t i = 0; i < kFrame.size(); ++i) {
      if (length_inside(kFrame.cell(i), a, b) > 1e-9) CHECK(visited.cells[i]);
    }
  }
}

TEST_CASE("marks along a line are the cells that it crosses, and no other") {
  for (std::uint64_t seed = 0; seed < cases(5000); ++seed) {
    CAPTURE(seed);
    const auto [a, b] = random_line(seed);
    CellSet marked(kFrame, 0);
    mark_line(kFrame, a, b, [&](std::size_t i) { marked.cells[i] = 1; });
    CHECK(marked[kFrame.cell(a)]);
    CHECK(marked[kFrame.cell(b)]);
    for (std::size_t i = 0; i < kFrame.size(); ++i) {
      const double inside = length_inside(kFrame.cell(i), a, b);
      if (inside > 1e-9) CHECK(marked.cells[i]);
      if (marked.cells[i]) CHECK(inside >= -1e-9);
    }
  }
}

TEST_CASE("a walk ends where it is told to") {
  int count = 0;
  CHECK_FALSE(walk_line(kFrame, {0.0, 0.0}, {1.0, 1.0}, [&](CellIndex) { return ++count < 5; }));
  CHECK(count == 5);
  CHECK(walked({0.25, 0.25}, {0.25, 0.25}).size() == 1);
}

}  // namespace
}  // namespace threewe::scene
