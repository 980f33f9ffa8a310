#include "sim/ray_caster.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "sim/ray_caster_kernel.hpp"
#include "sim/ray_caster_visibility.hpp"

namespace threewe::sim {

using kernel::CircleBlock;
using kernel::kBlock;
using kernel::SegmentBlock;
using kernel::Sweep;

// The blocks of a cell: segments from `segment_block` on, circles from `circle_block` on, the nearest first.
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
  std::vector<float> nearest_segment;  // [m] in each block, from anywhere in its cell: no more than that
  std::vector<float> nearest_circle;

  // From anywhere within `radius` [m].
  void add_cell(Vec2 center, double radius, const VisibleSet& visible);
  // What may be seen from a cell within `reach` [m], and more; from anywhere outside the grid if it is -1.
  kernel::Shapes seen_from(int cell, double reach) const;
  double clearance(Vec2 point, double most) const;
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

// Sorts shapes by their distance [m] from anywhere near a place: no more than that.
template <class Distance>
std::vector<std::pair<double, int>> nearest_first(const std::vector<int>& shapes, const Distance& distance) {
  std::vector<std::pair<double, int>> sorted;
  for (const int i : shapes) sorted.emplace_back(distance(i), i);
  std::ranges::stable_sort(sorted, {}, &std::pair<double, int>::first);
  return sorted;
}

// Rounded down.
float as_bound(double distance) { return static_cast<float>(0.999999 * distance); }

// How many of the first `places` shapes lie in blocks that are not all beyond `reach` [m].
int count_within(std::span<const float> nearest, int places, double reach) {
  int count = 0;
  for (const float distance : nearest) {
    if (static_cast<double>(distance) > reach) break;
    count += kBlock;
  }
  return std::min(count, places);
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

// [m] From a point to the nearest of the first `count` segments of a block, all relative to the same centre.
float nearest(const SegmentBlock& block, int count, float x, float y) {
  std::array<float, kBlock> squares;  // NOLINT: filled below, without a branch
  for (std::size_t j = 0; j < kBlock; ++j) {
    const float a_x = block.a_x[j] - x;
    const float a_y = block.a_y[j] - y;
    const float along_x = block.b_x[j] - block.a_x[j];
    const float along_y = block.b_y[j] - block.a_y[j];
    const float square = along_x * along_x + along_y * along_y;
    const float share = -(a_x * along_x + a_y * along_y) / (square > 1e-12F ? square : 1.0F);
    const float clamped = share < 0.0F ? 0.0F : share > 1.0F ? 1.0F : share;
    const float off_x = a_x + clamped * along_x;
    const float off_y = a_y + clamped * along_y;
    squares[j] = off_x * off_x + off_y * off_y;
  }
  return std::sqrt(*std::min_element(squares.begin(), squares.begin() + count));
}

float nearest(const CircleBlock& block, int count, float x, float y) {
  float least = std::numeric_limits<float>::infinity();
  for (int j = 0; j < count; ++j) {
    const float off_x = block.x[j] - x;
    const float off_y = block.y[j] - y;
    least = std::min(least, std::sqrt(off_x * off_x + off_y * off_y) - block.radius[j]);
  }
  return least;
}

// Beams `first` to `last` of a sweep as one of their own.
Sweep part(const Sweep& sweep, int first, int last) {
  return {sweep.origin + first * sweep.step, sweep.step, sweep.angle + first * sweep.increment, sweep.increment,
          last - first};
}

}  // namespace

void RayCaster::Table::add_cell(Vec2 center, double radius, const VisibleSet& visible) {
  Cell cell{center, static_cast<int>(segment_blocks.size()), 0, static_cast<int>(circle_blocks.size()), 0};
  const auto to_segment = [&](int i) {
    const scene::Segment& segment = slice.segments[static_cast<std::size_t>(i)];
    return std::max(distance(center, closest_on_segment(center, segment.a, segment.b)) - radius, 0.0);
  };
  const auto to_circle = [&](int i) {
    const scene::Circle& circle = slice.circles[static_cast<std::size_t>(i)];
    return std::max(distance(center, circle.center) - circle.radius - radius, 0.0);
  };
  for (const auto& [nearest, i] : nearest_first(visible.segments, to_segment)) {
    if (cell.segment_count % kBlock == 0) nearest_segment.push_back(as_bound(nearest));
    const scene::Segment& segment = slice.segments[static_cast<std::size_t>(i)];
    append(segment_blocks, cell.segment_block, cell.segment_count++, segment, center, i);
  }
  for (const auto& [nearest, i] : nearest_first(visible.circles, to_circle)) {
    if (cell.circle_count % kBlock == 0) nearest_circle.push_back(as_bound(nearest));
    const scene::Circle& circle = slice.circles[static_cast<std::size_t>(i)];
    append(circle_blocks, cell.circle_block, cell.circle_count++, circle, center, i);
  }
  cells.push_back(cell);
}

kernel::Shapes RayCaster::Table::seen_from(int index, double reach) const {
  const Cell& cell = index < 0 ? cells.back() : cells[static_cast<std::size_t>(index)];
  const auto blocks = [](const auto& all, int first, int places) {
    return std::span(all).subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(block_count(places)));
  };
  int segments = cell.segment_count;
  int circles = cell.circle_count;
  if (reach < kEverything) {
    segments = count_within(blocks(nearest_segment, cell.segment_block, segments), segments, reach);
    circles = count_within(blocks(nearest_circle, cell.circle_block, circles), circles, reach);
  }
  return {.center = cell.center,
          .segment_blocks = blocks(segment_blocks, cell.segment_block, segments),
          .segment_count = segments,
          .circle_blocks = blocks(circle_blocks, cell.circle_block, circles),
          .circle_count = circles,
          .segments = slice.segments,
          .circles = slice.circles};
}

double RayCaster::Table::clearance(Vec2 point, double most) const {
  const int index = grid.cell(point);
  const Cell& cell = index < 0 ? cells.back() : cells[static_cast<std::size_t>(index)];
  const auto x = static_cast<float>(point.x - cell.center.x);
  const auto y = static_cast<float>(point.y - cell.center.y);
  auto least = static_cast<float>(most);
  const auto look = [&](const auto& blocks, const std::vector<float>& bounds, int first, int places) {
    for (auto block = static_cast<std::size_t>(first); places > 0 && bounds[block] < least; ++block, places -= kBlock)
      least = std::min(least, nearest(blocks[block], std::min(places, kBlock), x, y));
  };
  look(segment_blocks, nearest_segment, cell.segment_block, cell.segment_count);
  look(circle_blocks, nearest_circle, cell.circle_block, cell.circle_count);
  constexpr double kRounding = 5e-4;  // [m] in single precision, 1 km away
  return std::min(most, double{least} - kRounding);
}

RayCaster::RayCaster(const scene::Slice& slice, double range_max) : range_max_(range_max) {
  auto table = std::make_shared<Table>();
  table->slice = slice;
  table->grid = covering_grid(slice);
  const auto visible = potentially_visible_sets(slice, table->grid, range_max);
  constexpr double kHalfDiagonal = 0.5 * std::numbers::sqrt2 * CellGrid::kSize;
  for (int i = 0; i < table->grid.count(); ++i)
    table->add_cell(table->grid.center(i), kHalfDiagonal, visible[static_cast<std::size_t>(i)]);
  const Vec2 size =
      CellGrid::kSize * Vec2{static_cast<double>(table->grid.width), static_cast<double>(table->grid.height)};
  table->add_cell(table->grid.origin + 0.5 * size, kEverything, everything(slice));
  table_ = std::move(table);
}

double RayCaster::clearance(Vec2 point, double most) const { return table_->clearance(point, most); }

void RayCaster::cast(const Pose2D& sensor, double angle_min, double angle_increment, std::span<float> ranges,
                     const MovingShapes& moving, double reach) const {
  cast_rolling(sensor, sensor, angle_min, angle_increment, ranges, moving, reach);
}

void RayCaster::cast_rolling(const Pose2D& begin, const Pose2D& end, double angle_min, double angle_increment,
                             std::span<float> ranges, const MovingShapes& moving, double reach) const {
  if (ranges.empty()) return;
  const double share = 1.0 / static_cast<double>(ranges.size());
  const double turn = wrap_angle(end.theta - begin.theta);
  const Sweep sweep{begin.position(), share * (end.position() - begin.position()), begin.theta + angle_min,
                    angle_increment + share * turn, static_cast<int>(ranges.size())};
  cast_part(sweep, ranges, moving, reach);
}

// Halves a sweep until it is short enough and all of it leaves from one cell, which is convex: if both ends are in it,
// so is what lies between.
void RayCaster::cast_part(const Sweep& sweep, std::span<float> ranges, const MovingShapes& moving, double reach) const {
  const int cell = table_->grid.cell(sweep.origin);
  const int last_cell = table_->grid.cell(sweep.origin + (sweep.count - 1) * sweep.step);
  if (sweep.count > 1 && (cell != last_cell || sweep.count > kernel::kMaxBeams)) {
    const int half = sweep.count / 2;
    cast_part(part(sweep, 0, half), ranges.first(static_cast<std::size_t>(half)), moving, reach);
    cast_part(part(sweep, half, sweep.count), ranges.subspan(static_cast<std::size_t>(half)), moving, reach);
    return;
  }
  kernel::Fan fan;
  kernel::begin(sweep, range_max_, fan);
  kernel::intersect(table_->seen_from(cell, reach), fan);
  intersect_moving(moving, fan);
  kernel::finish(fan, range_max_, ranges.data());
}

}  // namespace threewe::sim
