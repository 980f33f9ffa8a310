#include "nav/progress_monitor.hpp"

#include <algorithm>
#include <cmath>

namespace threewe::nav {

void ProgressMonitor::begin(Time now) {
  visited_.clear();
  nearest_ = std::numeric_limits<double>::infinity();
  longest_ = 0.0;
  last_ = now;
}

void ProgressMonitor::update(Time now, Vec2 position, double distance_left) {
  longest_ = std::max(longest_, distance_left);
  const auto cell = [this](double metres) { return static_cast<int>(std::floor(metres / place_)); };
  const bool new_place = visited_.insert({cell(position.x), cell(position.y)}).second;
  const bool nearer = distance_left > 0.0 && distance_left < nearest_ - params_.nearer;
  if (nearer) nearest_ = distance_left;
  if (!new_place && !nearer) return;
  last_ = now;
  longest_ = distance_left;
}

bool ProgressMonitor::stalled(Time now) const {
  return now - last_ > params_.patience + from_seconds(params_.detour * longest_ / speed_);
}

}  // namespace threewe::nav
