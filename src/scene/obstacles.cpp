#include "scene/obstacles.hpp"
#include "core/exact.hpp"
#include "core/numbers.hpp"

#include <algorithm>
#include <numbers>
#include <numeric>
#include <utility>

namespace threewe::scene {
namespace {

constexpr double kBucket = 0.5;  // [m]

std::vector<Vec2> outline_at(const Footprint& footprint, const Pose2D& pose) {
  const auto [s, c] = exact::sincos(pose.theta);
  std::vector<Vec2> outline;
  for (const Vec2 p : footprint.corners()) outline.push_back({pose.x + c * p.x - s * p.y, pose.y + s * p.x + c * p.y});
  return outline;
}

GridFrame frame_around(const std::vector<Solid>& solids, double margin) {
  if (solids.empty()) return {{}, kBucket, 0, 0};
  const auto [low, high] = bounds(solids);
  const auto cells = [&](double from, double to) { return static_cast<int>((to - from + 2.0 * margin) / kBucket) + 1; };
  return {{low.x - margin, low.y - margin}, kBucket, cells(low.x, high.x), cells(low.y, high.y)};
}

}  // namespace

Obstacles::Obstacles(std::vector<Solid> solids)
    : solids_(std::move(solids)), buckets_(frame_around(solids_, kReach), {}), everything_(solids_.size()) {
  std::iota(everything_.begin(), everything_.end(), 0);
  const GridFrame& frame = buckets_.frame;
  for (const int i : everything_) {
    const Solid& solid = solids_[static_cast<std::size_t>(i)];
    const auto [lowest, highest] = bounds(solid);
    const CellIndex low = frame.cell(lowest - Vec2{kReach, kReach});
    const CellIndex high = frame.cell(highest + Vec2{kReach, kReach});
    for (int y = std::max(low.y, 0); y <= std::min(high.y, frame.height - 1); ++y) {
      for (int x = std::max(low.x, 0); x <= std::min(high.x, frame.width - 1); ++x) {
        const double to_corner = 0.5 * std::numbers::sqrt2 * kBucket;
        if (distance_to(solid, frame.center({x, y})) <= to_corner + kReach) buckets_[{x, y}].push_back(i);
      }
    }
  }
}

const std::vector<int>& Obstacles::near(Vec2 point) const {
  static const std::vector<int> kNothing;
  const CellIndex cell = buckets_.frame.cell(point);
  return buckets_.frame.contains(cell) ? buckets_[cell] : kNothing;
}

bool Obstacles::collides(const Footprint& footprint, const Pose2D& pose) const {
  const std::vector<Vec2> outline = outline_at(footprint, pose);
  const double reach = footprint.circumscribed_radius();
  const std::vector<int>& candidates = reach <= kReach ? near(pose.position()) : everything_;
  return std::ranges::any_of(candidates, [&](int i) {
    const Solid& solid = solids_[static_cast<std::size_t>(i)];
    return distance(solid.center, pose.position()) < solid.radius + reach && overlaps(solid, outline);
  });
}

double Obstacles::clearance(const Footprint& footprint, const Pose2D& pose) const {
  const std::vector<Vec2> outline = outline_at(footprint, pose);
  const double reach = footprint.circumscribed_radius();
  double nearest = kInfinity;
  for (const Solid& solid : solids_) {
    if (distance(solid.center, pose.position()) - solid.radius - reach >= nearest) continue;
    nearest = std::min(nearest, distance_to(solid, outline));
  }
  return nearest;
}

double Obstacles::clearance(Vec2 point) const {
  const auto nearest_of = [&](const std::vector<int>& candidates) {
    double nearest = kInfinity;
    for (const int i : candidates) {
      const Solid& solid = solids_[static_cast<std::size_t>(i)];
      if (distance(solid.center, point) - solid.radius >= nearest) continue;
      nearest = std::min(nearest, distance_to(solid, point));
    }
    return nearest;
  };
  const double nearest = nearest_of(near(point));
  return nearest <= kReach ? nearest : nearest_of(everything_);
}

}  // namespace threewe::scene
