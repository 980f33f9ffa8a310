#include "nav/mppi/obstacle_field.hpp"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nav/mppi/obstacle_field.cpp"
#include "core/exact.hpp"
#include "core/highway-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace threewe::nav::mppi::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Floats = hn::CappedTag<float, kBlock>;
using Ints = hn::RebindToSigned<Floats>;
using V = hn::Vec<Floats>;

// How a robot stands, and what follows from it for all stamps.
struct Heading {
  float sin, cos;
  float columns, rows;            // [cells] from an obstacle to where it is out of sight
  float tan, cot;                 // rows for each column along the sides of the outline, and across
  float half_width, half_length;  // [rows] from the middle line to where obstacles beside it are out of sight
};

Heading heading_of(const StampShape& shape, double angle) {
  const exact::SinCos exactly = exact::sincos(angle);
  const auto sin = static_cast<float>(exactly.sin);
  const auto cos = static_cast<float>(exactly.cos);
  const float s = std::fabs(sin);
  const float c = std::fabs(cos);
  return {.sin = sin,
          .cos = cos,
          .columns = (shape.half_length * c + shape.half_width * s + shape.sight) / shape.cell,
          .rows = (shape.half_length * s + shape.half_width * c + shape.sight) / shape.cell,
          .tan = sin / cos,
          .cot = cos / sin,
          .half_width = (shape.half_width + shape.sight) / (c * shape.cell),
          .half_length = (shape.half_length + shape.sight) / (s * shape.cell)};
}

// Whole numbers from `low` to `high`, and within some bounds; a little more, since both are rounded.
struct Range {
  int first, end;
};
HWY_INLINE Range whole(float low, float high, int first, int end) {
  constexpr float kRounding = 0.01F;
  return {std::max(first, static_cast<int>(std::max(low + (1.0F - kRounding), 0.0F))),
          std::min(end, static_cast<int>(std::max(high + (1.0F + kRounding), 0.0F)))};
}

// The rows in which some cell of a vector of columns sees an obstacle: the outline and what is within sight of it lie
// between two pairs of lines.
HWY_INLINE Range rows_in_sight(const Heading& heading, const Cells& filled, float right, float row) {
  constexpr float kHalf = 0.5F * static_cast<float>(hn::MaxLanes(Floats()) - 1);
  const float along = heading.tan * right;
  const float across = -heading.cot * right;
  const float beside = heading.half_width + std::fabs(heading.tan) * kHalf;
  const float beyond = heading.half_length + std::fabs(heading.cot) * kHalf;
  const float up = std::min({heading.rows, along + beside, across + beyond});
  const float down = std::max({-heading.rows, along - beside, across - beyond});
  return whole(row - up, row - down, filled.first_row, filled.first_row + filled.rows);
}

// A column of vectors. Distances are kept as their squares outside of the outline and as they are (negative) inside:
// the order is the same.
HWY_INLINE void stamp_column(const StampShape& shape, const Stamp& stamp, const Heading& heading, int column,
                             const Range& rows, std::int32_t* cells, float* nearest) {
  const Floats d;
  const V zero = hn::Zero(d);
  const V packed = hn::BitCast(d, hn::Set(Ints(), stamp.packed));
  const V centre = hn::Iota(d, static_cast<float>(column) + 0.5F);
  const V dx = hn::Sub(hn::Set(d, stamp.x), hn::Mul(centre, hn::Set(d, shape.cell)));
  const V cos_dx = hn::Mul(hn::Set(d, heading.cos), dx);
  const V sin_dx = hn::Mul(hn::Set(d, heading.sin), dx);
  std::ptrdiff_t at = rows.first * kSide + column;
  for (int row = rows.first; row < rows.end; ++row, at += kSide) {
    const float dy = stamp.y - (static_cast<float>(row) + 0.5F) * shape.cell;
    const V ahead = hn::Add(cos_dx, hn::Set(d, heading.sin * dy));
    const V left = hn::Sub(hn::Set(d, heading.cos * dy), sin_dx);
    const V beyond_x = hn::Sub(hn::Abs(ahead), hn::Set(d, shape.half_length));
    const V beyond_y = hn::Sub(hn::Abs(left), hn::Set(d, shape.half_width));
    const V out_x = hn::Max(beyond_x, zero);
    const V out_y = hn::Max(beyond_y, zero);
    const V outside = hn::Add(hn::Mul(out_x, out_x), hn::Mul(out_y, out_y));
    const V distance = hn::Add(outside, hn::Min(hn::Max(beyond_x, beyond_y), zero));
    const V before = hn::LoadU(d, nearest + at);
    const auto nearer = hn::Lt(distance, before);
    if (hn::AllFalse(d, nearer)) continue;
    hn::StoreU(hn::IfThenElse(nearer, distance, before), d, nearest + at);
    const V other = hn::BitCast(d, hn::LoadU(Ints(), cells + at));
    hn::StoreU(hn::BitCast(Ints(), hn::IfThenElse(nearer, packed, other)), Ints(), cells + at);
  }
}

// Heading by heading, since all cells of one stay near in memory. Vectors may begin anywhere, but none crosses the end
// of what is filled.
void stamp_all(const StampShape& shape, const Cells& filled, std::span<const Stamp> stamps, std::int32_t* cells,
               float* nearest) {
  constexpr int kLanes = static_cast<int>(hn::MaxLanes(Floats()));
  const int end = filled.first_column + filled.columns;
  for (int bin = 0; bin < kBins; ++bin, cells += std::ptrdiff_t{kSide} * kSide) {
    for (int row = filled.first_row; row < filled.first_row + filled.rows; ++row) {
      const std::ptrdiff_t first = row * kSide + filled.first_column;
      std::fill_n(cells + first, filled.columns, kNothing);
      std::fill_n(nearest + first, filled.columns, shape.sight * shape.sight);
    }
    const Heading heading = heading_of(shape, (bin + 0.5) * exact::kPi / kBins);
    for (const Stamp& stamp : stamps) {
      const float middle = stamp.x / shape.cell - 0.5F;
      const float row = stamp.y / shape.cell - 0.5F;
      const Range columns = whole(middle - heading.columns, middle + heading.columns, filled.first_column, end);
      const int vectors = (columns.end - columns.first + kLanes - 1) / kLanes;
      int column = std::min(columns.first, end - vectors * kLanes);
      for (int i = 0; i < vectors; ++i, column += kLanes) {
        const float right = middle - (static_cast<float>(column) + 0.5F * static_cast<float>(kLanes - 1));
        const Range rows = rows_in_sight(heading, filled, right, row);
        stamp_column(shape, stamp, heading, column, rows, cells, nearest);
      }
    }
  }
}

}  // namespace threewe::nav::mppi::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace threewe::nav::mppi {
namespace {

HWY_EXPORT(stamp_all);

constexpr std::size_t kCells = std::size_t{kBins} * kSide * kSide;
constexpr int kUnitsPerCell = 240;  // the window and all around it that matters fit into 16 bits

}  // namespace

void stamp_rows(const StampShape& shape, const Cells& filled, std::span<const Stamp> stamps,
                std::span<std::int32_t> cells, std::span<float> nearest) {
  HWY_DYNAMIC_DISPATCH(stamp_all)(shape, filled, stamps, cells.data(), nearest.data());
}

ObstacleField::ObstacleField(const Footprint& footprint, double reach, double sight, const Params& params)
    : cell_(std::max(params.follower.step, reach / (0.5 * kSide - 1.0))),
      thinning_(params.follower.thinning),
      unit_(cell_ / kUnitsPerCell),
      sight_(static_cast<float>(sight)),
      cells_(kCells, kNothing),
      nearest_(std::size_t{kSide} * kSide) {
  Vec2 low = footprint.corners().front();
  Vec2 high = low;
  for (const Vec2 c : footprint.corners()) {
    low = {std::min(low.x, c.x), std::min(low.y, c.y)};
    high = {std::max(high.x, c.x), std::max(high.y, c.y)};
  }
  half_length_ = static_cast<float>(0.5 * (high.x - low.x));
  half_width_ = static_cast<float>(0.5 * (high.y - low.y));
  base_to_middle_ = 0.5 * (low + high);
}

void ObstacleField::update(std::span<const Vec2> obstacles, Vec2 middle, Vec2 low, Vec2 high) {
  middle_ = middle;
  filled_ = cells_around(low, high);
  stamps_.clear();
  const double corner = -0.5 * kSide * cell_;
  Vec2 last{1e9, 1e9};  // scans come in order, so that neighbours follow each other
  for (const Vec2 p : obstacles) {
    if (distance(p, last) < thinning_) continue;
    last = p;
    add_stamp(static_cast<float>(p.x - middle.x - corner), static_cast<float>(p.y - middle.y - corner));
  }
  stamp_rows({static_cast<float>(cell_), half_length_, half_width_, sight_}, filled_, stamps_, cells_, nearest_);
}

bool ObstacleField::covers(Vec2 low, Vec2 high) const {
  const Cells asked = cells_around(low, high);
  return asked.first_column >= filled_.first_column && asked.first_row >= filled_.first_row &&
         asked.first_column + asked.columns <= filled_.first_column + filled_.columns &&
         asked.first_row + asked.rows <= filled_.first_row + filled_.rows;
}

// Whole vectors of them, within the window.
Cells ObstacleField::cells_around(Vec2 low, Vec2 high) const {
  const auto row = [&](double along) {
    return std::clamp(static_cast<int>(std::floor(along / cell_)) + kSide / 2, 0, kSide - 1);
  };
  constexpr int kWhole = static_cast<int>(kBlock);
  const int first = row(low.x - middle_.x) / kWhole * kWhole;
  const int columns = row(high.x - middle_.x) / kWhole * kWhole + kWhole - first;
  return {first, row(low.y - middle_.y), columns, row(high.y - middle_.y) + 1 - row(low.y - middle_.y)};
}

// Where it can be within sight of some filled cell.
void ObstacleField::add_stamp(float x, float y) {
  const auto cell = static_cast<float>(cell_);
  const float around = sight_ + exact::sqrt(half_length_ * half_length_ + half_width_ * half_width_);
  const auto is_far = [&](float along, int first, int count) {
    return along < static_cast<float>(first) * cell - around ||
           along > static_cast<float>(first + count) * cell + around;
  };
  if (is_far(x, filled_.first_column, filled_.columns) || is_far(y, filled_.first_row, filled_.rows)) return;
  const auto in_units = [&](float along) {
    return static_cast<int>(std::lround((static_cast<double>(along) - 0.5 * kSide * cell_) / unit_));
  };
  stamps_.push_back({x, y, pack(in_units(x), in_units(y))});
}

FieldView ObstacleField::view() const {
  return {.cells = cells_.data(),
          .cells_per_metre = static_cast<float>(1.0 / cell_),
          .unit = static_cast<float>(unit_),
          .half_length = half_length_,
          .half_width = half_width_,
          .middle_x = static_cast<float>(base_to_middle_.x),
          .middle_y = static_cast<float>(base_to_middle_.y),
          .first_column = static_cast<float>(filled_.first_column),
          .last_column = static_cast<float>(filled_.first_column + filled_.columns - 1),
          .first_row = static_cast<float>(filled_.first_row),
          .last_row = static_cast<float>(filled_.first_row + filled_.rows - 1)};
}

}  // namespace threewe::nav::mppi
#endif
