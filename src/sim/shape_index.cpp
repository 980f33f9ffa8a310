#include "sim/shape_index.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "threewe/core/errors.hpp"

namespace threewe::sim {
namespace {

double distance_to(const scene::Slice& slice, std::size_t shape, Vec2 point) {
  if (shape >= slice.segments.size()) {
    const scene::Circle& circle = slice.circles[shape - slice.segments.size()];
    return distance(point, circle.center) - circle.radius;
  }
  const scene::Segment& segment = slice.segments[shape];
  const Vec2 along = segment.b - segment.a;
  const double length_squared = dot(along, along);
  const double t = length_squared > 0.0 ? std::clamp(dot(point - segment.a, along) / length_squared, 0.0, 1.0) : 0.0;
  return distance(point, segment.a + t * along);
}

struct Box {
  Vec2 low;
  Vec2 high;
};

Box join(const Box& a, const Box& b) {
  return {{std::min(a.low.x, b.low.x), std::min(a.low.y, b.low.y)},
          {std::max(a.high.x, b.high.x), std::max(a.high.y, b.high.y)}};
}

Box box_around(const scene::Slice& slice, std::size_t shape) {
  if (shape >= slice.segments.size()) {
    const auto& [center, radius, object] = slice.circles[shape - slice.segments.size()];
    return {center - Vec2{radius, radius}, center + Vec2{radius, radius}};
  }
  const scene::Segment& segment = slice.segments[shape];
  return join({segment.a, segment.a}, {segment.b, segment.b});
}

}  // namespace

ShapeIndex::ShapeIndex(scene::Slice slice, double reach, double cell)
    : slice_(std::move(slice)), cells_per_metre_(1.0 / cell) {
  const std::size_t count = slice_.segments.size() + slice_.circles.size();
  if (count > std::numeric_limits<std::uint16_t>::max()) {
    throw ConfigError(fmt::format("the scene has {} edges; at most 65,535 can be simulated", count));
  }
  if (count == 0) return;

  // the grid covers every point that has anything in reach
  Box all = box_around(slice_, 0);
  for (std::size_t i = 1; i < count; ++i) all = join(all, box_around(slice_, i));
  origin_ = all.low - Vec2{reach, reach};
  width_ = static_cast<int>((all.high.x + reach - origin_.x) * cells_per_metre_) + 1;
  height_ = static_cast<int>((all.high.y + reach - origin_.y) * cells_per_metre_) + 1;

  // a shape belongs to a cell when any point of the cell may have it in reach
  const double cell_reach = reach + 0.5 * cell * std::numbers::sqrt2;
  std::vector<std::vector<std::uint16_t>> cells(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  for (std::size_t shape = 0; shape < count; ++shape) {
    const Box box = box_around(slice_, shape);
    const auto column = [&](double x) {
      return std::clamp(static_cast<int>((x - origin_.x) * cells_per_metre_), 0, width_ - 1);
    };
    const auto row = [&](double y) {
      return std::clamp(static_cast<int>((y - origin_.y) * cells_per_metre_), 0, height_ - 1);
    };
    for (int y = row(box.low.y - cell_reach); y <= row(box.high.y + cell_reach); ++y) {
      for (int x = column(box.low.x - cell_reach); x <= column(box.high.x + cell_reach); ++x) {
        const Vec2 center = origin_ + cell * Vec2{x + 0.5, y + 0.5};
        if (distance_to(slice_, shape, center) > cell_reach) continue;
        const auto place = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
        cells[place].push_back(static_cast<std::uint16_t>(shape));
      }
    }
  }

  for (const auto& shapes : cells) {
    begins_.push_back(static_cast<std::uint32_t>(shapes_.size()));
    shapes_.insert(shapes_.end(), shapes.begin(), shapes.end());
  }
  begins_.push_back(static_cast<std::uint32_t>(shapes_.size()));
}

}  // namespace threewe::sim
