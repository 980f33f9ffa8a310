// Which surface each column of a picture shows in which rows. Walls and prisms stand upright and the camera is level,
// so that a column is a problem in the plane: along it, everything is a matter of inverse depth w = 1/x alone.
#pragma once

#include <cstdint>
#include <vector>

#include "sim/renderer/candidates.hpp"
#include "sim/renderer/kernel.hpp"

namespace threewe::sim::view {

/// How far away a surface is in a row of some slope: its inverse depth is at_horizon + rise * slope.
struct Inverse {
  float at_horizon = 0.0F;
  float rise = 0.0F;
};
/// That of a level surface, `z` above the eye.
inline Inverse inverse_of_level(double z) { return {0.0F, static_cast<float>(1.0 / z)}; }

/// A surface in one column.
struct Run {
  enum class Kind : std::uint8_t { nothing, sky, hills, ceiling, floor, side, skirting, decor, top, bottom };
  Kind kind{};
  int face = 0;
  const Candidate* candidate = nullptr;
  Inverse inverse{};
  double near = 0.0;  // the same, of a side, in full
  const FloorRegion* floor = nullptr;
  const Decor* decor = nullptr;
};

/// The numbers by which pixels draw a surface along the ray (1, s).
void fill(const Run& run, const Place& place, const View& view, double s, Span& span);

struct RowRange {
  int begin = 0;
  int end = 0;
};

/// A candidate before the wall, in one column.
struct ColumnHit {
  const Candidate* candidate = nullptr;
  int face = 0;
  double near = 0.0;  // inverse depths
  double far = 0.0;
};

/// Working memory of a strip.
struct Columns {
  std::vector<Span> spans;  // of all columns, from top to bottom in each

  std::array<std::vector<ColumnHit>, kBlock> hits;  // of a block of columns
  std::vector<Run> runs;                            // of a column
  std::vector<RowRange> base;                       // rows of its first runs
  std::vector<float> inverse;                       // by row: the largest inverse depth so far, and whose it is
  std::vector<std::int32_t> owner;
  std::vector<std::int32_t> changed;  // rows at which it changes
};

/// Finds what `count` columns show; spans count them from `first`, the first of a block.
void find_spans(const Place& place, const View& view, const Rows& rows, const Candidates& candidates, int first,
                int count, Columns& columns);

}  // namespace threewe::sim::view
