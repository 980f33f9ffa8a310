#include "safety/creep_mode.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>

#include "core/exact.hpp"
#include "core/numbers.hpp"
#include "map/scan_hits.hpp"

namespace threewe::safety {
namespace {

constexpr double kRounding = 1.0 + 1e-9;
constexpr double kBoxedIn = 4.0;  // margins before and behind the body, together

double corner_speed(const GateModel& model, const Velocity& v) {
  return exact::hypot(v.vx, v.vy) + std::abs(v.omega) * model.footprint.circumscribed_radius();
}

// The outline along a direction, from which across it: where it begins and ends.
struct Extent {
  double rear = kInfinity;
  double front = -kInfinity;
};

// An outline, which is convex, as it moves straight on.
class Corridor {
 public:
  // What is in it by no more than `noise` [m] is at its sides.
  Corridor(const Footprint& footprint, Vec2 direction, double noise)
      : footprint_(footprint), direction_(direction), noise_(noise) {
    for (const Vec2 corner : footprint.corners()) {
      const double across = cross(direction, corner);
      right_ = std::min(right_, across);
      left_ = std::max(left_, across);
    }
  }
  // [m] from the body along its way to a point that it would run into: negative behind it, infinite beside it.
  double gap(Vec2 point) const {
    const double across = cross(direction_, point);
    if (across < right_ + noise_ || across > left_ - noise_) return kInfinity;
    const auto [rear, front] = extent(across);
    const double along = dot(direction_, point);
    return along > 0.5 * (rear + front) ? std::max(along - front, 0.0) : std::min(along - rear, -0.0);
  }

 private:
  Extent extent(double across) const {
    Extent extent;
    const auto& corners = footprint_.corners();
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Vec2 a = corners[i];
      const Vec2 b = corners[(i + 1) % corners.size()];
      const double from = cross(direction_, a);
      const double to = cross(direction_, b);
      if (std::min(from, to) > across || std::max(from, to) < across) continue;
      const double share = from == to ? 0.0 : (across - from) / (to - from);
      for (const Vec2 end : {a + share * (b - a), from == to ? b : a + share * (b - a)}) {
        extent.rear = std::min(extent.rear, dot(direction_, end));
        extent.front = std::max(extent.front, dot(direction_, end));
      }
    }
    return extent;
  }

  const Footprint& footprint_;
  Vec2 direction_;
  double noise_;
  double right_ = kInfinity;
  double left_ = -kInfinity;
};

// Those that are near.
std::vector<Vec2> without_noise(const GateModel& model, std::span<const Vec2> hits, const Pose2D& odom_from_base) {
  const Vec2 lidar = odom_from_base * model.base_from_lidar.value_or(Vec2{});
  return map::smoothed_near(odom_from_base.position(), model.creep.sight, hits, lidar, model.creep.flat);
}

}  // namespace

Limits creep_limits(const GateModel& model) {
  const double turning = std::max(0.0, model.creep.corner_speed - model.creep.speed);
  Limits limits = model.limits;
  limits.linear = std::min(limits.linear, model.creep.speed);
  limits.angular = std::min(limits.angular, turning / model.footprint.circumscribed_radius());
  return limits;
}

bool is_creeping(const GateModel& model, const GateState& state) {
  constexpr std::size_t kSettling = 2;  // periods: motors follow a step in about as many
  const auto pending = static_cast<std::size_t>((model.reaction + kControlPeriod - 1ns) / kControlPeriod);
  const std::size_t count = std::min(pending + kSettling, RecentCommands::kSize);
  for (std::size_t i = 0; i < count; ++i) {
    if (corner_speed(model, state.recent[i]) > model.creep.corner_speed * kRounding) return false;
  }
  return true;
}

bool is_in_passage(const GateModel& model, std::span<const Vec2> hits, const Pose2D& odom_from_base) {
  const Pose2D base_from_odom = inverse(odom_from_base);
  return std::ranges::any_of(without_noise(model, hits, odom_from_base), [&](Vec2 hit) {
    return model.footprint.signed_distance(base_from_odom * hit) < model.margin;
  });
}

Passage measure_passage(const GateModel& model, const Velocity& velocity, const Surroundings& surroundings,
                        const Pose2D& odom_from_base) {
  Passage passage;
  passage.beside = without_noise(model, surroundings.hits, odom_from_base);
  passage.assumed.assign(surroundings.assumed.begin(), surroundings.assumed.end());
  const double speed = exact::hypot(velocity.vx, velocity.vy);
  if (speed == 0.0) return passage;  // turning on the spot, nothing is ahead

  const Corridor corridor(model.footprint, {velocity.vx / speed, velocity.vy / speed}, model.noise);
  const Pose2D base_from_odom = inverse(odom_from_base);
  const auto gap = [&](Vec2 hit) { return corridor.gap(base_from_odom * hit); };
  double before = kInfinity;
  double behind = kInfinity;
  for (const auto* kind : {&passage.beside, &passage.assumed}) {
    for (const Vec2 hit : *kind) {
      const double along = gap(hit);
      double& nearest = std::signbit(along) ? behind : before;
      nearest = std::min(nearest, std::abs(along));
    }
  }
  if (before + behind < kBoxedIn * model.margin) return passage;
  const auto is_ahead = [&](Vec2 hit) { return !std::signbit(gap(hit)) && gap(hit) < kInfinity; };
  for (auto* kind : {&passage.beside, &passage.assumed}) {
    std::ranges::copy_if(*kind, std::back_inserter(passage.ahead), is_ahead);
    std::erase_if(*kind, is_ahead);
  }
  return passage;
}

}  // namespace threewe::safety
