#include "nav/progress_monitor.hpp"

#include <algorithm>
#include <cmath>

namespace threewe::nav {
namespace {

constexpr double kCell = 0.5;         // [m] places that count as different ones
constexpr double kNearer = 0.1;       // [m] by which the path must have become shorter
constexpr Duration kPatience = 120s;  // for recovery, narrow passages, and people who stand about
constexpr double kDetour = 2.0;       // times what the rest of the path takes

}  // namespace

void ProgressMonitor::begin(Time now) {
  *this = ProgressMonitor(speed_);
  last_ = now;
}

void ProgressMonitor::update(Time now, Vec2 position, double distance_left) {
  longest_ = std::max(longest_, distance_left);
  const auto cell = [](double metres) { return static_cast<int>(std::floor(metres / kCell)); };
  const bool new_place = visited_.insert({cell(position.x), cell(position.y)}).second;
  const bool nearer = distance_left > 0.0 && distance_left < nearest_ - kNearer;
  if (nearer) nearest_ = distance_left;
  if (!new_place && !nearer) return;
  last_ = now;
  longest_ = distance_left;
}

bool ProgressMonitor::stalled(Time now) const {
  return now - last_ > kPatience + from_seconds(kDetour * longest_ / speed_);
}

}  // namespace threewe::nav
