#include "nav/mppi/path_table.hpp"

#include <algorithm>
#include <cmath>

#include "nav/polyline.hpp"

namespace threewe::nav::mppi {

void PathTable::lay_out(std::span<const Vec2> path, Vec2 robot, Vec2 middle, double unit, double reach) {
  constexpr int kMost = static_cast<int>(kPathPoints) - 1;
  const PathPoint here = nearest_on_path(path, robot);
  const double left = length_after(path, here);
  ends_ = left <= reach;

  // so many points that their spacing hardly changes while the path gets shorter
  const double laid_out = std::min(left, reach);
  last_ = std::clamp(static_cast<int>(std::ceil(laid_out / reach * kMost)), 1, kMost);
  spacing_ = std::max(laid_out / last_, 1e-4);
  unit_ = unit;
  for (int i = 0; i <= last_; ++i) {
    const Vec2 p = point_after(path, here, i * laid_out / last_);
    const auto in_units = [&](double along) {
      return static_cast<int>(std::lround(std::clamp(along / unit, -32000.0, 32000.0)));
    };
    points_[static_cast<std::size_t>(i)] = p;
    packed_[static_cast<std::size_t>(i)] = pack(in_units(p.x - middle.x), in_units(p.y - middle.y));
  }
  turn_along();
}

// Directions round corners off a little: a robot does not turn at a point.
void PathTable::turn_along() {
  constexpr int kAround = 2;
  Vec2 last{1.0, 0.0};
  for (int i = 0; i <= last_; ++i) {
    const Vec2 from = points_[static_cast<std::size_t>(std::max(i - kAround, 0))];
    const Vec2 to = points_[static_cast<std::size_t>(std::min(i + kAround, last_))];
    const double length = distance(from, to);
    if (length > 1e-6) last = (1.0 / length) * (to - from);
    directions_[static_cast<std::size_t>(i)] =
        pack(static_cast<int>(std::lround(32000.0 * last.x)), static_cast<int>(std::lround(32000.0 * last.y)));
  }
}

Vec2 PathTable::point(double ahead) const {
  const int i = std::clamp(static_cast<int>(std::lround(ahead / spacing_)), 0, last_);
  return points_[static_cast<std::size_t>(i)];
}

PathView PathTable::view() const {
  return {.points = packed_.data(),
          .directions = directions_.data(),
          .unit = static_cast<float>(unit_),
          .per_spacing = static_cast<float>(1.0 / spacing_),
          .spacing = static_cast<float>(spacing_),
          .last = static_cast<float>(last_)};
}

}  // namespace threewe::nav::mppi
