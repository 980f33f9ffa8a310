#include "nav/mppi/obstacle_field.hpp"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nav/mppi/obstacle_field.cpp"
#include "threewe/core/highway-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace threewe::nav::mppi::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Floats = hn::CappedTag<float, kBlock>;
using Ints = hn::RebindToSigned<Floats>;
using V = hn::Vec<Floats>;

// One row of cells, for a robot whose heading has this sine and cosine.
HWY_INLINE void stamp_row(const Stamp& stamp, float sin, float cos, float dy, std::int32_t* cells, float* nearest) {
  const Floats d;
  const V zero = hn::Zero(d);
  const V packed_lanes = hn::BitCast(d, hn::Set(Ints(), stamp.packed));
  for (int column = 0; column < stamp.columns; column += static_cast<int>(hn::Lanes(d))) {
    const V centre = hn::Iota(d, static_cast<float>(stamp.first_column + column) + 0.5F);
    const V dx = hn::Sub(hn::Set(d, stamp.x), hn::Mul(centre, hn::Set(d, stamp.cell)));
    const V ahead = hn::Add(hn::Mul(hn::Set(d, cos), dx), hn::Set(d, sin * dy));
    const V left = hn::Sub(hn::Set(d, cos * dy), hn::Mul(hn::Set(d, sin), dx));
    const V beyond_x = hn::Sub(hn::Abs(ahead), hn::Set(d, stamp.half_length));
    const V beyond_y = hn::Sub(hn::Abs(left), hn::Set(d, stamp.half_width));
    const V out_x = hn::Max(beyond_x, zero);
    const V out_y = hn::Max(beyond_y, zero);
    const V outside = hn::Add(hn::Mul(out_x, out_x), hn::Mul(out_y, out_y));
    const V distance = hn::Add(outside, hn::Min(hn::Max(beyond_x, beyond_y), zero));
    const V before = hn::LoadU(d, nearest + column);
    const auto nearer = hn::Lt(distance, before);
    hn::StoreU(hn::IfThenElse(nearer, distance, before), d, nearest + column);
    const V other = hn::BitCast(d, hn::LoadU(Ints(), cells + column));
    hn::StoreU(hn::BitCast(Ints(), hn::IfThenElse(nearer, packed_lanes, other)), Ints(), cells + column);
  }
}

void stamp_all(const Stamp& stamp, std::int32_t* cells, float* nearest) {
  for (int bin = 0; bin < kBins; ++bin) {
    const exact::SinCos heading = exact::sincos((bin + 0.5) * exact::kPi / kBins);
    for (int row = stamp.first_row; row < stamp.first_row + stamp.rows; ++row) {
      const float dy = stamp.y - (static_cast<float>(row) + 0.5F) * stamp.cell;
      const std::ptrdiff_t first = (bin * kSide + row) * kSide + stamp.first_column;
      stamp_row(stamp, static_cast<float>(heading.sin), static_cast<float>(heading.cos), dy, cells + first,
                nearest + first);
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
constexpr std::int32_t kNothing = static_cast<std::int32_t>(0x80008000);  // far outside of the window
constexpr int kUnitsPerCell = 240;  // the window and all around it that matters fit into 16 bits
constexpr double kThinned = 0.006;  // [m] of obstacles nearer to each other one is enough

}  // namespace

void stamp_rows(const Stamp& stamp, std::span<std::int32_t> cells, std::span<float> nearest) {
  HWY_DYNAMIC_DISPATCH(stamp_all)(stamp, cells.data(), nearest.data());
}

ObstacleField::ObstacleField(const Footprint& footprint, double reach, double sight)
    : cell_(std::max(0.02, reach / (0.5 * kSide - 1.0))),
      unit_(cell_ / kUnitsPerCell),
      sight_(static_cast<float>(sight)),
      cells_(kCells, kNothing),
      nearest_(kCells, sight_ * sight_) {
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

void ObstacleField::update(std::span<const Vec2> obstacles, Vec2 middle) {
  middle_ = middle;
  std::fill(cells_.begin(), cells_.end(), kNothing);
  std::fill(nearest_.begin(), nearest_.end(), sight_ * sight_);
  const double corner = -0.5 * kSide * cell_;
  Vec2 last{1e9, 1e9};  // scans come in order, so that neighbours follow each other
  for (const Vec2 p : obstacles) {
    if (distance(p, last) < kThinned) continue;
    last = p;
    stamp(static_cast<float>(p.x - middle.x - corner), static_cast<float>(p.y - middle.y - corner));
  }
}

// On all cells from which it can be within sight.
void ObstacleField::stamp(float x, float y) {
  const auto cell = static_cast<float>(cell_);
  const float around = sight_ + exact::sqrt(half_length_ * half_length_ + half_width_ * half_width_);
  const auto bounded = [&](float along) { return std::clamp(static_cast<int>(std::floor(along / cell)), -1, kSide); };
  Stamp stamp{.x = x, .y = y, .cell = cell, .half_length = half_length_, .half_width = half_width_};
  stamp.first_column = std::max(bounded(x - around), 0);
  stamp.first_row = std::max(bounded(y - around), 0);
  stamp.columns = std::min(bounded(x + around), kSide - 1) + 1 - stamp.first_column;
  stamp.rows = std::min(bounded(y + around), kSide - 1) + 1 - stamp.first_row;
  if (stamp.columns <= 0 || stamp.rows <= 0) return;

  // whole blocks of columns, none of which crosses the end of a row
  constexpr int kWhole = static_cast<int>(kBlock);
  stamp.columns = (stamp.columns + kWhole - 1) / kWhole * kWhole;
  stamp.first_column = std::min(stamp.first_column, kSide - stamp.columns);
  const auto in_units = [&](float along) {
    return static_cast<int>(std::lround((static_cast<double>(along) - 0.5 * kSide * cell_) / unit_));
  };
  stamp.packed = pack(in_units(x), in_units(y));
  stamp_rows(stamp, cells_, nearest_);
}

FieldView ObstacleField::view() const {
  return {.cells = cells_.data(),
          .cells_per_metre = static_cast<float>(1.0 / cell_),
          .unit = static_cast<float>(unit_),
          .half_length = half_length_,
          .half_width = half_width_,
          .middle_x = static_cast<float>(base_to_middle_.x),
          .middle_y = static_cast<float>(base_to_middle_.y)};
}

}  // namespace threewe::nav::mppi
#endif
