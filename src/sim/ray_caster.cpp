#include "sim/ray_caster.hpp"

#include <algorithm>
#include <array>

#include "sim/ray_caster_kernel.hpp"
#include "sim/ray_caster_visibility.hpp"

namespace threewe::sim {

using kernel::CircleBlock;
using kernel::kBlock;
using kernel::SegmentBlock;
using kernel::Sweep;

// The blocks of a cell: segments from `segment_block` on, circles from `circle_block` on.
struct RayCaster::Cell {
  Vec2 center;
  int segment_block = 0;
  int segment_count = 0;
  int circle_block = 0;
  int circle_count = 0;
};

struct RayCaster::Table {
  scene::Slice slice;
  CellGrid grid;
  std::vector<Cell> cells;  // the last one sees everything: for sensors outside the grid
  std::vector<SegmentBlock> segment_blocks;
  std::vector<CircleBlock> circle_blocks;

  void add_cell(Vec2 center, const VisibleSet& visible);
  // What may be seen from a cell; from anywhere outside the grid if it is -1.
  kernel::Shapes seen_from(int cell) const;
};

namespace {

int block_count(int places) { return (places + kBlock - 1) / kBlock; }

// Places one shape behind the other.
template <class Block, class Shape>
void append(std::vector<Block>& blocks, int first, int place, const Shape& shape, Vec2 center, int index) {
  if (place % kBlock == 0) blocks.emplace_back();
  const int block = first + place / kBlock;
  put(blocks[static_cast<std::size_t>(block)], place % kBlock, shape, center, index);
}

VisibleSet everything(const scene::Slice& slice) {
  VisibleSet all;
  for (std::size_t i = 0; i < slice.segments.size(); ++i) all.segments.push_back(static_cast<int>(i));
  for (std::size_t i = 0; i < slice.circles.size(); ++i) all.circles.push_back(static_cast<int>(i));
  return all;
}

// Lets beams meet shapes that are in no table, a few at a time.
void intersect_moving(const MovingShapes& moving, kernel::Fan& fan) {
  constexpr std::size_t kAtOnce = kBlock;
  const Vec2 center = fan.sweep.origin;
  for (std::size_t i = 0; i < std::max(moving.segments.size(), moving.circles.size()); i += kAtOnce) {
    SegmentBlock segments;
    CircleBlock circles;
    kernel::Shapes shapes;
    shapes.center = center;
    shapes.segment_blocks = {&segments, 1};
    shapes.circle_blocks = {&circles, 1};
    shapes.segments = moving.segments;
    shapes.circles = moving.circles;
    for (std::size_t k = i; k < std::min(i + kAtOnce, moving.segments.size()); ++k) {
      put(segments, shapes.segment_count++, moving.segments[k], center, static_cast<int>(k));
    }
    for (std::size_t k = i; k < std::min(i + kAtOnce, moving.circles.size()); ++k) {
      put(circles, shapes.circle_count++, moving.circles[k], center, static_cast<int>(k));
    }
    intersect(shapes, fan);
  }
}

// Beams `first` to `last` of a sweep as one of their own.
Sweep part(const Sweep& sweep, int first, int last) {
  return {sweep.origin + first * sweep.step, sweep.step, sweep.angle + first * sweep.increment, sweep.increment,
          last - first};
}

}  // namespace

void RayCaster::Table::add_cell(Vec2 center, const VisibleSet& visible) {
  Cell cell{center, static_cast<int>(segment_blocks.size()), 0, static_cast<int>(circle_blocks.size()), 0};
  for (const int i : visible.segments) {
    const scene::Segment& segment = slice.segments[static_cast<std::size_t>(i)];
    append(segment_blocks, cell.segment_block, cell.segment_count++, segment, center, i);
  }
  for (const int i : visible.circles) {
    const scene::Circle& circle = slice.circles[static_cast<std::size_t>(i)];
    append(circle_blocks, cell.circle_block, cell.circle_count++, circle, center, i);
  }
  cells.push_back(cell);
}

kernel::Shapes RayCaster::Table::seen_from(int index) const {
  const Cell& cell = index < 0 ? cells.back() : cells[static_cast<std::size_t>(index)];
  const auto blocks = [](const auto& all, int first, int places) {
    return std::span(all).subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(block_count(places)));
  };
  return {.center = cell.center,
          .segment_blocks = blocks(segment_blocks, cell.segment_block, cell.segment_count),
          .segment_count = cell.segment_count,
          .circle_blocks = blocks(circle_blocks, cell.circle_block, cell.circle_count),
          .circle_count = cell.circle_count,
          .segments = slice.segments,
          .circles = slice.circles};
}

RayCaster::RayCaster(const scene::Slice& slice, double range_max) : range_max_(range_max) {
  auto table = std::make_shared<Table>();
  table->slice = slice;
  table->grid = covering_grid(slice);
  const auto visible = potentially_visible_sets(slice, table->grid, range_max);
  for (int i = 0; i < table->grid.count(); ++i)
    table->add_cell(table->grid.center(i), visible[static_cast<std::size_t>(i)]);
  const Vec2 size =
      CellGrid::kSize * Vec2{static_cast<double>(table->grid.width), static_cast<double>(table->grid.height)};
  table->add_cell(table->grid.origin + 0.5 * size, everything(slice));
  table_ = std::move(table);
}

void RayCaster::cast(const Pose2D& sensor, double angle_min, double angle_increment, std::span<float> ranges,
                     const MovingShapes& moving) const {
  cast_rolling(sensor, sensor, angle_min, angle_increment, ranges, moving);
}

void RayCaster::cast_rolling(const Pose2D& begin, const Pose2D& end, double angle_min, double angle_increment,
                             std::span<float> ranges, const MovingShapes& moving) const {
  if (ranges.empty()) return;
  const double share = 1.0 / static_cast<double>(ranges.size());
  const double turn = wrap_angle(end.theta - begin.theta);
  const Sweep sweep{begin.position(), share * (end.position() - begin.position()), begin.theta + angle_min,
                    angle_increment + share * turn, static_cast<int>(ranges.size())};
  cast_part(sweep, ranges, moving);
}

// Halves a sweep until it is short enough and all of it leaves from one cell, which is convex: if both ends are in it,
// so is what lies between.
void RayCaster::cast_part(const Sweep& sweep, std::span<float> ranges, const MovingShapes& moving) const {
  const int cell = table_->grid.cell(sweep.origin);
  const int last_cell = table_->grid.cell(sweep.origin + (sweep.count - 1) * sweep.step);
  if (sweep.count > 1 && (cell != last_cell || sweep.count > kernel::kMaxBeams)) {
    const int half = sweep.count / 2;
    cast_part(part(sweep, 0, half), ranges.first(static_cast<std::size_t>(half)), moving);
    cast_part(part(sweep, half, sweep.count), ranges.subspan(static_cast<std::size_t>(half)), moving);
    return;
  }
  kernel::Fan fan;
  kernel::begin(sweep, range_max_, fan);
  kernel::intersect(table_->seen_from(cell), fan);
  intersect_moving(moving, fan);
  kernel::finish(fan, range_max_, ranges.data());
}

}  // namespace threewe::sim
