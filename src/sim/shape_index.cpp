#include "threewe/sim/shape_index.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "threewe/core/errors.hpp"

namespace threewe::sim {
namespace {

double distance_to_segment(Vec2 point, const scene::Segment& segment) {
  const Vec2 along = segment.b - segment.a;
  const double length_squared = dot(along, along);
  const double t = length_squared > 0.0 ? std::clamp(dot(point - segment.a, along) / length_squared, 0.0, 1.0) : 0.0;
  return distance(point, segment.a + t * along);
}

}  // namespace

ShapeIndex::ShapeIndex(scene::Slice slice, double reach) : slice_(std::move(slice)) {
  const std::size_t count = slice_.segments.size() + slice_.circles.size();
  if (count > std::numeric_limits<std::uint16_t>::max()) {
    throw ConfigError(fmt::format("the scene has {} edges; at most 65,535 can be simulated", count));
  }
  if (count == 0) return;

  // the grid covers every point that has anything in reach
  Vec2 low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  Vec2 high{-low.x, -low.y};
  const auto include = [&](Vec2 p, double r) {
    low = {std::min(low.x, p.x - r), std::min(low.y, p.y - r)};
    high = {std::max(high.x, p.x + r), std::max(high.y, p.y + r)};
  };
  for (const scene::Segment& segment : slice_.segments) include(segment.a, reach), include(segment.b, reach);
  for (const scene::Circle& circle : slice_.circles) include(circle.center, circle.radius + reach);
  origin_ = low;
  width_ = static_cast<int>((high.x - low.x) / kCell) + 1;
  height_ = static_cast<int>((high.y - low.y) / kCell) + 1;

  // a shape belongs to a cell when any point of the cell may have it in reach
  const double cell_reach = reach + 0.5 * kCell * std::numbers::sqrt2;
  for (int row = 0; row < height_; ++row) {
    for (int column = 0; column < width_; ++column) {
      begins_.push_back(static_cast<std::uint32_t>(shapes_.size()));
      const Vec2 center = origin_ + kCell * Vec2{column + 0.5, row + 0.5};
      for (std::size_t i = 0; i < slice_.segments.size(); ++i) {
        if (distance_to_segment(center, slice_.segments[i]) <= cell_reach) {
          shapes_.push_back(static_cast<std::uint16_t>(i));
        }
      }
      for (std::size_t i = 0; i < slice_.circles.size(); ++i) {
        const scene::Circle& circle = slice_.circles[i];
        if (distance(center, circle.center) - circle.radius <= cell_reach) {
          shapes_.push_back(static_cast<std::uint16_t>(slice_.segments.size() + i));
        }
      }
    }
  }
  begins_.push_back(static_cast<std::uint32_t>(shapes_.size()));
}

std::span<const std::uint16_t> ShapeIndex::near(Vec2 point) const {
  const double x = (point.x - origin_.x) * (1.0 / kCell);
  const double y = (point.y - origin_.y) * (1.0 / kCell);
  if (!(x >= 0.0 && y >= 0.0 && x < width_ && y < height_)) return {};
  const auto cell = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  return std::span(shapes_).subspan(begins_[cell], begins_[cell + 1] - begins_[cell]);
}

}  // namespace threewe::sim
