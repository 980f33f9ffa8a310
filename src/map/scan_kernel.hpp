// Vectorised insertion of a scan into the cells of a map.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "threewe/core/pose.hpp"

namespace threewe::map {

/// What a scan says about a cell.
enum Mark : std::uint8_t { kUnseen = 0, kPassed = 1, kHit = 2 };

/// A straight line, in cells from the corner of a grid.
struct GridLine {
  Vec2 from, to;
};

/// Marks all cells that lines cross as passed: those that walk_grid_line visits. `marks`: (height, width), which holds
/// all of them.
void mark_passed(std::span<const GridLine> lines, int width, std::span<std::uint8_t> marks);

/// What a mark adds to the evidence, and how far it goes.
struct Evidence {
  std::int8_t hit = 0, pass = 0, max = 0, min = 0;
};

/// Adds evidence to the cells `first` ... `last` - 1 by their marks, which become kUnseen; never to 0, which is for
/// cells that were never seen. May do so with cells after `last`, too. Adds the cells to `changed` in which it is
/// another one than before, or which were hit, in order.
void add_evidence(const Evidence& evidence, std::size_t first, std::size_t last, std::span<std::uint8_t> marks,
                  std::span<std::int8_t> log_odds, std::vector<std::uint32_t>& changed);

}  // namespace threewe::map
