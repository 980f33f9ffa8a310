#include "perception/repeat_check.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "core/exact.hpp"
#include "slam/range_noise_estimator.hpp"

namespace threewe::perception {
namespace {

bool same(const LaserScan& a, const LaserScan& b) { return a.ranges == b.ranges; }
// An inertial unit without noise settles for seconds, by less than any resolves: 16 bits are 1e-4 rad/s and 6e-4 m/s^2.
bool same(const IMUData& a, const IMUData& b) {
  constexpr double kTurns = 1e-6;   // [rad/s]
  constexpr double kSpeeds = 1e-5;  // [m/s^2]
  const auto near = [](const auto& one, const auto& other, double resolution) {
    return std::ranges::equal(one, other, [=](double x, double y) { return std::fabs(x - y) <= resolution; });
  };
  return near(a.angular_velocity, b.angular_velocity, kTurns) &&
         near(a.linear_acceleration, b.linear_acceleration, kSpeeds);
}
bool same(const Odometry& a, const Odometry& b) { return a.pose == b.pose && a.velocity == b.velocity; }
bool same(const BatteryState&, const BatteryState&) { return false; }  // it may well stay as it is
bool same(const RangeData& a, const RangeData& b) { return a.range == b.range; }
bool same(const Picture& a, const Picture& b) {
  // those that were not asked for are not drawn for our sake
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

// Would ranges change as the lidar moves along? Not between two walls that it moves along, with nothing at their ends.
bool depends_on(const Params::Repeats& params, const LaserScan& scan, const Velocity& velocity) {
  if (std::fabs(velocity.omega) > params.turns) return true;
  const double speed = exact::hypot(velocity.vx, velocity.vy);
  if (speed == 0.0) return true;  // others say that the robot moves
  const std::size_t n = scan.ranges.size();
  const auto hit = [&](std::size_t i) {
    const auto range = static_cast<double>(scan.ranges[i % n]);
    const double angle = scan.angle_min + static_cast<double>(i) * scan.angle_increment;
    return range > 0.0 && range < scan.range_max ? std::optional(rotate({range, 0.0}, angle)) : std::nullopt;
  };
  double steep = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const auto here = hit(i);
    const auto next = hit(i + 1);
    if (!here || !next) continue;
    const Vec2 along = *next - *here;
    if (std::fabs(cross(along, {velocity.vx, velocity.vy})) > params.slope * norm(along) * speed) steep += 1.0;
  }
  return steep > params.steep * static_cast<double>(n);
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
  const auto* picture = std::get_if<Picture>(&data);
  if (picture != nullptr && !picture->is_drawn()) return false;  // its content is unknown
  frozen_ = is_suspect(data, motion);
  return frozen_;
}

bool RepeatCheck::is_suspect(const SampleData& data, const Motion& motion) {
  const bool repeated = before_ && same(*before_, data);
  before_ = data;
  if (!repeated) {
    note_change(motion);
    return false;
  }
  ++in_a_row_;
  if (!motion.moving && repeats_ == 0) return false;
  ++repeats_;
  // echoes without noise are the same at rest, whether their sensor is frozen or not: the robot has to try
  const bool lively = changes_at_rest_ >= params_.lively;
  if (motion.still && !lively && std::holds_alternative<RangeData>(data)) return false;
  return !is_empty(data) && should_have_changed(data, motion);
}

// What was taken for frozen says nothing about noise, nor does the first reading.
void RepeatCheck::note_change(const Motion& motion) {
  if (in_a_row_ >= params_.quiet && !frozen_) quiet_ = true;
  repeats_ = in_a_row_ = 0;
  ++changes_;
  if (motion.still) ++changes_at_rest_;
}

bool RepeatCheck::should_have_changed(const SampleData& data, const Motion& motion) const {
  const bool lively = changes_at_rest_ >= params_.lively;
  if (const auto* odometry = std::get_if<Odometry>(&data)) {
    // wheels that turn, or are commanded to, at the same place
    const Velocity& v = odometry->velocity;
    return repeats_ >= 2 &&
           (motion.driven || exact::hypot(v.vx, v.vy) > params_.moves || std::fabs(v.omega) > params_.turns);
  }
  if (std::holds_alternative<IMUData>(data)) return lively && !quiet_ && repeats_ >= 4;
  if (std::holds_alternative<Picture>(data)) return lively && !quiet_;
  if (std::holds_alternative<RangeData>(data)) return lively || changes_ >= params_.lively_on_way;
  // a lidar without noise sees the same where it moves between bare walls
  const auto* scan = std::get_if<LaserScan>(&data);
  return scan == nullptr || slam::range_noise_of(*scan) > params_.noise ||
         (repeats_ >= 2 && depends_on(params_, *scan, motion.velocity));
}

}  // namespace threewe::perception
