#include "slam/obstacle_points.hpp"

#include <algorithm>
#include <functional>
#include <iterator>

#include "map/scan_hits.hpp"

namespace threewe::slam {

void ObstaclePoints::update(std::span<const map::Beam> beams, double range_bias, const Pose2D& odom_from_base,
                            Vec2 lidar_in_odom, double nearest) {
  const std::vector<Vec2> nearby = what_may_vanish(lidar_in_odom, nearest);
  points_.clear();
  for (const map::Beam& b : beams) {
    if (b.hit) points_.push_back(odom_from_base * (b.origin + (b.range - range_bias) * b.direction));
  }
  seen_ = points_.size();
  keep_unseen(nearby);
}

// Of what is known, that which is nearer than the lidar can see; its noise would add up from scan to scan.
std::vector<Vec2> ObstaclePoints::what_may_vanish(Vec2 lidar_in_odom, double nearest) const {
  const double reach = nearest + params_.blur;
  const auto is_unseen = [&](Vec2 p) { return distance(p, lidar_in_odom) < reach; };
  const auto known = std::span(points_);
  std::vector<Vec2> near = map::smoothed_near(lidar_in_odom, reach + params_.neighbourhood, known.first(seen_),
                                              lidar_in_odom, params_.neighbourhood);
  std::erase_if(near, std::not_fn(is_unseen));
  std::ranges::copy_if(known.subspan(seen_), std::back_inserter(near), is_unseen);
  return near;
}

// What came nearer than the lidar can see is still there.
void ObstaclePoints::keep_unseen(const std::vector<Vec2>& nearby) {
  for (const Vec2 p : nearby) {
    const auto is_same = [&](Vec2 other) { return distance(p, other) < params_.same; };
    const auto kept = points_.begin() + static_cast<std::ptrdiff_t>(seen_);
    if (std::none_of(kept, points_.end(), is_same)) points_.push_back(p);
  }
}

}  // namespace threewe::slam
