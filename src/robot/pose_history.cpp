#include "robot/pose_history.hpp"

#include <algorithm>
#include <cstddef>

namespace threewe {

void PoseHistory::add(Time time, const Pose2D& odom_from_base) {
  constexpr std::size_t kRemembered = 64;  // ticks, 1.3 s: longer than any turn takes to arrive
  if (track_.empty() || track_.back().time < time) track_.push_back({time, odom_from_base});
  if (track_.size() > kRemembered) track_.erase(track_.begin());
}

Pose2D PoseHistory::at(Time time) const {
  const auto after = std::ranges::lower_bound(track_, time, {}, &Point::time);
  if (after == track_.end()) return track_.back().odom_from_base;
  if (after == track_.begin() || after->time == time) return after->odom_from_base;
  const Point& before = *(after - 1);
  const double share = to_seconds(time - before.time) / to_seconds(after->time - before.time);
  return interpolate(before.odom_from_base, after->odom_from_base, share);
}

}  // namespace threewe
