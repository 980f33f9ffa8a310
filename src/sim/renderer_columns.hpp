// Which surface each column of a picture shows in which rows. Walls and prisms stand upright and the camera is level,
// so that a column is a problem in the plane: along it, everything is a matter of inverse depth w = 1/x alone.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "sim/renderer_kernel.hpp"
#include "sim/renderer_place.hpp"

namespace threewe::sim::view {

/// A column begins to show something else at a row. Spans of one row are chained by `next`.
struct Span {
  std::int32_t column = 0;
  std::int32_t next = -1;
  Fields fields{};
};

/// A solid that may be in the picture, in the camera's frame. Along the ray (1, s) it lies between the inverse depths
/// max(far lines) and min(near lines), each of which is `slope * s + offset`; or between the roots of a quadratic.
struct Candidate {
  struct Line {
    double slope = 0.0;
    double offset = 0.0;
    int face = 0;
  };
  const VisibleSolid* visible = nullptr;
  int solid = -1;  // index of one that stands in the scene
  Colour colour;
  bool is_disc = false;
  int first_column = 0;
  int last_column = 0;
  double nearest = 0.0;  // no point of it has a greater inverse depth
  double low = 0.0;      // heights relative to the eye [m]
  double high = 0.0;
  int near_count = 0;
  int far_count = 0;
  Line near[4];
  Line far[4];
  Vec2 center;          // of a disc
  double beyond = 0.0;  // square of the distance to its centre, less that of its radius
};

/// A surface in one column.
struct Run {
  enum class Kind : std::uint8_t { nothing, sky, hills, ceiling, floor, side, skirting, decor, top, bottom };
  Kind kind{};
  int face = 0;
  const Candidate* candidate = nullptr;
  double inverse = 0.0;  // of a side
  const FloorRegion* floor = nullptr;
  const Decor* decor = nullptr;
};

struct RowRange {
  int begin = 0;
  int end = 0;
};

/// Working memory.
struct Columns {
  std::vector<Candidate> walls;   // from floor to ceiling
  std::vector<Candidate> others;  // what may be seen before them
  struct Entry {
    double nearest = 0.0;  // these three are the candidate's own, close at hand
    std::int32_t first_column = 0;
    std::int32_t last_column = 0;
    std::int32_t candidate = 0;
  };
  std::vector<std::vector<Entry>> blocks;  // `others` by blocks of columns
  struct WallHit {
    double inverse = 0.0;
    std::int32_t wall = -1;
    std::int32_t face = 0;
  };
  std::vector<WallHit> wall_hits;      // by column: the nearest wall
  std::vector<double> block_inverses;  // by block: the farthest of those

  std::vector<float> slopes;             // of rows, z / x
  std::vector<Span> spans;               // of a strip
  std::vector<std::int32_t> first_span;  // by row

  std::vector<Run> runs;       // of a column
  std::vector<RowRange> base;  // rows of its first runs
  std::vector<float> inverse;  // by row: the largest inverse depth so far, and whose it is
  std::vector<std::int32_t> owner;
};

/// Works through a picture strip by strip: fills `columns.spans` and `first_span` with what the strip's columns show,
/// counted from the strip's first, and calls `draw(first, count)`.
void find_spans(const Place& place, const CameraIntrinsics& camera, const CameraPose& view, const Paint& paint,
                std::span<const VisibleSolid> moving, Columns& columns, const std::function<void(int, int)>& draw);

}  // namespace threewe::sim::view
