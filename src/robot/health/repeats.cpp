#include "robot/health/repeats.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "threewe/core/exact.hpp"

namespace threewe::health {
namespace {

constexpr int kLively = 4;       // changes while the robot stands: what changes is noise, and noise never stops
constexpr int kLivelyOnWay = 6;  // the same for echoes, of which few come while it stands

bool same(const LaserScan& a, const LaserScan& b) { return a.ranges == b.ranges; }
bool same(const IMUData& a, const IMUData& b) {
  return a.angular_velocity == b.angular_velocity && a.linear_acceleration == b.linear_acceleration;
}
bool same(const Odometry& a, const Odometry& b) { return a.pose == b.pose && a.velocity == b.velocity; }
bool same(const BatteryState&, const BatteryState&) { return false; }  // it may well stay as it is
bool same(const RangeData& a, const RangeData& b) { return a.range == b.range; }
bool same(const Picture& a, const Picture& b) {
  // those that nobody has looked at are not drawn for our sake
  return a.is_drawn() && b.is_drawn() && a.image().color == b.image().color;
}

bool same(const SampleData& a, const SampleData& b) {
  return std::visit(
      [&b](const auto& data) {
        const auto* other = std::get_if<std::decay_t<decltype(data)>>(&b);
        return other != nullptr && same(data, *other);
      },
      a);
}

// A reading that says nothing is often the same.
bool is_empty(const SampleData& data) {
  if (const auto* scan = std::get_if<LaserScan>(&data)) {
    const auto farthest = static_cast<float>(scan->range_max);
    return std::ranges::none_of(scan->ranges, [=](float range) { return range > 0.0F && range < farthest; });
  }
  const auto* echo = std::get_if<RangeData>(&data);
  return echo != nullptr && (echo->range <= echo->range_min || echo->range >= echo->range_max);
}

}  // namespace

bool RepeatCheck::is_frozen(const SampleData& data, const Motion& motion) {
  const bool repeated = before_ && same(*before_, data);
  before_ = data;
  if (!repeated) {
    repeats_ = 0;
    ++changes_;
    if (motion.still) ++changes_at_rest_;
    return false;
  }
  if (!motion.moving && repeats_ == 0) return false;
  ++repeats_;
  // echoes without noise are the same at rest, whether their sensor is frozen or not: the robot has to try
  const bool lively = changes_at_rest_ >= kLively;
  if (motion.still && !lively && std::holds_alternative<RangeData>(data)) return false;
  return !is_empty(data) && should_have_changed(data, motion);
}

bool RepeatCheck::should_have_changed(const SampleData& data, const Motion& motion) const {
  const bool lively = changes_at_rest_ >= kLively;
  if (const auto* odometry = std::get_if<Odometry>(&data)) {
    // wheels that turn, or are told to, at the same place
    const Velocity& v = odometry->velocity;
    return repeats_ >= 2 && (motion.driven || exact::hypot(v.vx, v.vy) > 0.01 || std::fabs(v.omega) > 0.05);
  }
  if (std::holds_alternative<IMUData>(data)) return lively && repeats_ >= 4;
  if (std::holds_alternative<RangeData>(data)) return lively || changes_ >= kLivelyOnWay;
  return true;
}

}  // namespace threewe::health
