// Marks and evidence of many cells at a time against those of one cell after the other, with any vectors.
#include "map/scan_kernel.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "core/grid_line.hpp"
#include "core/targets.hpp"
#include "draw.hpp"

namespace threewe::map {
namespace {

// A point in a grid: anywhere, on a border between cells, or at a corner of four.
Vec2 draw_point(Draw& draw, int width, int height) {
  const double x = draw(0.0, width);
  const double y = draw(0.0, height);
  switch (draw.whole(0, 3)) {
    case 0: return {std::floor(x), y};
    case 1: return {std::floor(x), std::floor(y)};
    default: return {x, y};
  }
}

TEST_CASE("the cells that are marked along lines are those that a walk along each of them visits") {
  for (std::uint64_t seed = 0; seed < cases(3000); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    const int width = draw.whole(1, 80);
    const int height = draw.whole(1, 80);
    const Vec2 from = draw_point(draw, width, height);
    std::vector<GridLine> lines;
    for (int i = draw.whole(0, 20); i > 0; --i) {
      const bool together = draw.whole(0, 1) == 0;
      const Vec2 to = draw_point(draw, width, height);
      const bool straight = draw.whole(0, 9) == 0;
      lines.push_back({together ? from : draw_point(draw, width, height), straight ? Vec2{to.x, from.y} : to});
    }

    std::vector<std::uint8_t> expected(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), kUnseen);
    for (const GridLine& line : lines) {
      walk_grid_line(line.from, line.to, [&](int x, int y) {
        expected[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)] = kPassed;
        return true;
      });
    }
    for (const std::string& target : available_targets()) {
      CAPTURE(target);
      force_target(target);
      std::vector<std::uint8_t> marks(expected.size(), kUnseen);
      mark_passed(lines, width, marks);
      REQUIRE(marks == expected);
    }
    force_target("");
  }
}

TEST_CASE("evidence is that of one cell after the other, and what has changed is told in order") {
  for (std::uint64_t seed = 0; seed < cases(3000); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    const auto byte = [&](int low, int high) { return static_cast<std::int8_t>(draw.whole(low, high)); };
    const Evidence evidence{byte(1, 127), byte(-128, -1), byte(1, 127), byte(-128, -1)};
    const int size = draw.whole(1, 400);
    std::vector<std::uint8_t> marks(static_cast<std::size_t>(size), kUnseen);
    std::vector<std::int8_t> log_odds;
    for (int i = 0; i < size; ++i) log_odds.push_back(byte(evidence.min, evidence.max));
    const int first = draw.whole(0, size - 1);
    const int last = draw.whole(first, size);
    for (int i = first; i < last; ++i) marks[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(draw.whole(0, 2));

    std::vector<std::int8_t> expected = log_odds;
    std::vector<std::uint32_t> expected_changed;
    for (std::size_t i = 0; i < marks.size(); ++i) {
      if (marks[i] == kUnseen) continue;
      const bool hit = marks[i] == kHit;
      const int sum = log_odds[i] + (hit ? evidence.hit : evidence.pass);
      const int known = sum != 0 ? sum : hit ? 1 : -1;
      expected[i] = static_cast<std::int8_t>(std::clamp<int>(known, evidence.min, evidence.max));
      if (hit || expected[i] != log_odds[i]) expected_changed.push_back(static_cast<std::uint32_t>(i));
    }
    for (const std::string& target : available_targets()) {
      CAPTURE(target);
      force_target(target);
      std::vector<std::uint8_t> left = marks;
      std::vector<std::int8_t> now = log_odds;
      std::vector<std::uint32_t> changed;
      add_evidence(evidence, static_cast<std::size_t>(first), static_cast<std::size_t>(last), left, now, changed);
      REQUIRE(now == expected);
      REQUIRE(changed == expected_changed);
      REQUIRE(std::ranges::count(left, kUnseen) == size);
    }
    force_target("");
  }
}

}  // namespace
}  // namespace threewe::map
