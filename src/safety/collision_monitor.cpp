#include "safety/collision_monitor.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory_resource>
#include <span>
#include <vector>

#include "core/exact.hpp"
#include "hardware/limits.hpp"

namespace threewe::safety {
namespace {

constexpr double kPeriod = to_seconds(kControlPeriod);
constexpr double kRounding = 1e-9;    // [m], and of shares of a period
constexpr double kStandStill = 1e-3;  // [m/s] and [rad/s], slower than this is not worth creeping
constexpr int kBisections = 10;       // the speed is found to a thousandth

Velocity scaled(double s, const Velocity& v) { return {s * v.vx, s * v.vy, s * v.omega}; }

Velocity blend(const Velocity& a, const Velocity& b, double t) {
  return {a.vx + t * (b.vx - a.vx), a.vy + t * (b.vy - a.vy), a.omega + t * (b.omega - a.omega)};
}

// [s] to stand-still when all components shrink together, so that braking keeps to the arc.
double stopping_time(const Limits& limits, const Velocity& v) {
  return std::max(exact::hypot(v.vx, v.vy) / limits.linear_braking, std::abs(v.omega) / limits.angular_acceleration);
}

// One period of braking along the arc.
Velocity braked(const Limits& limits, const Velocity& v) {
  if (v == Velocity{}) return v;
  const double time = stopping_time(limits, v);
  return time <= kPeriod ? Velocity{} : scaled(1.0 - kPeriod / time, v);
}

// [m] that no point of the outline exceeds in a period, wherever the robot turns.
double way_of_corners(const GateModel& model, const Velocity& v) {
  return (exact::hypot(v.vx, v.vy) + std::abs(v.omega) * model.footprint.circumscribed_radius()) * kPeriod;
}

// A pose with the sine and cosine of its heading.
struct Frame {
  Vec2 origin;
  exact::SinCos heading{0.0, 1.0};

  Vec2 from_outside(Vec2 p) const {
    const auto [s, c] = heading;
    const Vec2 d = p - origin;
    return {c * d.x + s * d.y, c * d.y - s * d.x};
  }
  Frame operator*(const Frame& b) const {
    const auto [s, c] = heading;
    return {origin + Vec2{c * b.origin.x - s * b.origin.y, s * b.origin.x + c * b.origin.y},
            {s * b.heading.cos + c * b.heading.sin, c * b.heading.cos - s * b.heading.sin}};
  }
};

// An arc that turns by an angle: its chord along and across its first direction, in shares of its length, and the sine
// and cosine of the angle.
struct Bend {
  double along;
  double across;
  exact::SinCos heading;
};

Bend bend(double angle) {
  if (std::abs(angle) > 0.25) {
    const exact::SinCos heading = exact::sincos(angle);
    return {heading.sin / angle, (1.0 - heading.cos) / angle, heading};
  }
  // sin(a) / a and (1 - cos(a)) / a by their series, which end here for double
  constexpr auto kOver = [](int a, int b) { return 1.0 / (a * b); };
  const double z = angle * angle;
  const auto sum = [z](auto... factors) {
    double inner = 1.0;
    ((inner = 1.0 - z * factors * inner), ...);
    return inner;
  };
  const double along = sum(kOver(10, 11), kOver(8, 9), kOver(6, 7), kOver(4, 5), kOver(2, 3));
  const double across = 0.5 * angle * sum(kOver(11, 12), kOver(9, 10), kOver(7, 8), kOver(5, 6), kOver(3, 4));
  return {along, across, {angle * along, 1.0 - angle * across}};
}

// A velocity for one period and, as the case may be, braking to a stand-still after it: all of it along one arc.
struct Arc {
  Velocity v;
  double way = 0.0;      // [m] that corners go in the first period, at most
  double shrink = 1.0;   // by this share of the first, each period brings less way than the one before
  double periods = 1.0;  // at the first velocity would lead at least as far

  static Arc of_one_period(const GateModel& model, const Velocity& v) { return {v, way_of_corners(model, v)}; }
  static Arc that_brakes(const GateModel& model, const Velocity& v) {
    const double braking = stopping_time(model.limits, v) / kPeriod;
    return {v, way_of_corners(model, v), 1.0 / braking, 1.0 + 0.5 * braking};
  }

  double whole_way() const { return periods * way; }
  // Where so many periods at the first velocity lead.
  Frame after(double many) const {
    const double seconds = many * kPeriod;
    const auto [along, across, heading] = bend(v.omega * seconds);
    return {{seconds * (along * v.vx - across * v.vy), seconds * (across * v.vx + along * v.vy)}, heading};
  }
};

// [m] that corners go at most from the turning point on, whatever is decided now.
double way_to_stand_still(const GateModel& model, const Velocity& last, const Velocity& command) {
  const Velocity fastest{.vx = std::max(exact::hypot(command.vx, command.vy), exact::hypot(last.vx, last.vy)),
                         .omega = std::max(std::abs(command.omega), std::abs(last.omega))};
  return Arc::that_brakes(model, fastest).whole_way();
}

// How many commands the robot has yet to obey.
std::size_t count_pending(const GateModel& model) {
  return static_cast<std::size_t>((model.reaction + kControlPeriod - 1ns) / kControlPeriod);
}

// [m] that corners go by them, at most.
double way_of_pending(const GateModel& model, const GateState& state) {
  double way = 0.0;
  const std::size_t pending = count_pending(model);
  for (std::size_t i = 0; i < pending; ++i) way += way_of_corners(model, state.recent[i]);
  return way;
}

// What the footprint must not come nearer to than required.
struct Obstacle {
  Vec2 at;                // in a frame that stands still
  double margin = 0.0;    // [m] of its kind
  double depth = 0.0;     // [m] of its kind
  double required = 0.0;  // [m]
  double slack = 0.0;     // [m] that corners can go at least before it is nearer than that
};
using Near = std::pmr::vector<Obstacle>;

// [m] between outline and obstacle, negative inside; a little less for what is beyond the margin.
double clearance(const GateModel& model, Vec2 in_base) {
  const double rough = model.footprint.distance_to_box(in_base);
  return rough > model.margin ? rough : model.footprint.signed_distance(in_base);
}

// From the robot's point of view, those that are not too far to matter on a way of so many metres.
void select_near(const GateModel& model, const Obstacles& obstacles, const Pose2D& base, double way, Near& near) {
  const double reach = obstacles.margin + way;
  const double sight = model.footprint.circumscribed_radius() + reach;
  const auto is_in_sight = [&](Vec2 p) {
    const Vec2 d = p - base.position();
    return dot(d, d) <= sight * sight;
  };
  const auto first = std::ranges::find_if(obstacles.points, is_in_sight);
  if (first == obstacles.points.end()) return;

  const Frame frame{base.position(), exact::sincos(base.theta)};
  for (const Vec2 p : std::span(first, obstacles.points.end())) {
    if (!is_in_sight(p)) continue;
    const Vec2 at = frame.from_outside(p);
    if (model.footprint.distance_to_box(at) > reach) continue;
    const double distance = clearance(model, at);
    const double required = std::min(distance, obstacles.margin);
    near.push_back({at, obstacles.margin, obstacles.depth, required, distance - required});
  }
}

// Follows the arc past one obstacle, from pose to pose of the sweep, and calls `visit(obstacle, clearance [m])` until
// it answers false. An obstacle that has slack is looked at when that is used up, and not before.
template <typename Visit>
bool follow(const GateModel& model, const Frame& start, const Arc& arc, Obstacle& obstacle, const Visit& visit) {
  if (obstacle.slack < arc.whole_way()) {
    const Vec2 at = start.from_outside(obstacle.at);
    double gone = 0.0;   // in periods at the first velocity
    double share = 1.0;  // of the first period's way
    while (share > kRounding) {
      const double steps = share * arc.way / model.sweep_step - kRounding;
      const int poses = steps > 1.0 ? static_cast<int>(std::ceil(steps)) : 1;
      for (int i = 1; i <= poses && obstacle.slack < (gone + share) * arc.way; ++i) {
        const double periods = gone + share * (static_cast<double>(i) / poses);
        if (obstacle.slack >= periods * arc.way) continue;
        const double distance = clearance(model, arc.after(periods).from_outside(at));
        if (!visit(obstacle, distance)) return false;
        obstacle.slack = periods * arc.way + distance - obstacle.required;
      }
      gone += share;
      share -= arc.shrink;
    }
  }
  obstacle.slack -= arc.whole_way();
  return true;
}

// What each obstacle must keep: the margin, but never more than braking at once would leave. What lies inside the
// outline already may come no deeper than its kind may, and never licenses touching something else. From here on they
// are looked at from the turning point.
void settle_requirements(const GateModel& model, const Frame& turning_point, Near& near) {
  double common = model.margin;
  double common_of_lesser = model.margin;  // of what may be nearer from the first
  for (const Obstacle& obstacle : near) {
    double& least = obstacle.margin < model.margin ? common_of_lesser : common;
    least = std::min(least, std::max(obstacle.required, 0.0));
  }
  for (Obstacle& obstacle : near) {
    obstacle.at = turning_point.from_outside(obstacle.at);
    const double least = obstacle.margin < model.margin ? common_of_lesser : common;
    if (obstacle.required < -kRounding) obstacle.required = std::min(obstacle.required, -obstacle.depth);
    obstacle.required = std::min(obstacle.required, least) - kRounding;
    obstacle.slack = clearance(model, obstacle.at) - obstacle.required;
  }
}

}  // namespace

Velocity clear_of_obstacles(const GateModel& model, const GateState& state, const Velocity& command,
                            std::span<const Obstacles> obstacles, const Pose2D& base) {
  if (std::ranges::all_of(obstacles, [](const Obstacles& o) { return o.points.empty(); })) return command;
  const double way_of_decision = way_to_stand_still(model, state.last(), command);
  const double way = way_of_pending(model, state) + way_of_decision;
  std::array<std::byte, 8192> room;  // NOLINT: what is used is filled
  std::pmr::monotonic_buffer_resource memory(room.data(), room.size());
  Near near(&memory);
  for (const Obstacles& kind : obstacles) select_near(model, kind, base, way, near);
  if (near.empty()) return command;

  // the robot will first obey what was commanded before
  const auto keep_nearest = [](Obstacle& obstacle, double distance) {
    obstacle.required = std::min(obstacle.required, distance);
    return true;
  };
  Frame turning_point;
  for (std::size_t i = count_pending(model); i-- > 0;) {
    const Velocity& v = state.recent[i];
    if (v == Velocity{}) continue;
    const Arc arc = Arc::of_one_period(model, v);
    for (Obstacle& obstacle : near) follow(model, turning_point, arc, obstacle, keep_nearest);
    turning_point = turning_point * arc.after(1.0);
  }

  // braking at once is always allowed, and the measure of what else is
  const Velocity fallback = braked(model.limits, state.last());
  const Arc braking = Arc::that_brakes(model, fallback);
  for (Obstacle& obstacle : near) follow(model, turning_point, braking, obstacle, keep_nearest);
  settle_requirements(model, turning_point, near);
  std::erase_if(near, [&](const Obstacle& obstacle) { return obstacle.slack >= way_of_decision; });
  if (near.empty()) return command;

  // what was in the way last comes first, since it will be in the way again
  const auto keeps_clear = [&](const Velocity& v) {
    const Arc arc = Arc::that_brakes(model, v);
    const auto is_in_the_way = [&](Obstacle obstacle) {
      return !follow(model, {}, arc, obstacle,
                     [](const Obstacle& o, double distance) { return distance >= o.required; });
    };
    const auto found = std::ranges::find_if(near, is_in_the_way);
    if (found == near.end()) return true;
    std::iter_swap(found, near.begin());
    return false;
  };
  if (keeps_clear(command)) return command;

  // who stands and cannot even creep stays: so it is for nearly all who press against something
  if (fallback == Velocity{}) {
    const double creeping = kStandStill / std::max(exact::hypot(command.vx, command.vy), std::abs(command.omega));
    if (creeping >= 1.0 || !keeps_clear(scaled(creeping, command))) return {};
  }

  // the largest step from braking towards the command that keeps clear
  const auto between = [&](double t) {
    return within_acceleration(model.limits, state.last(), blend(fallback, command, t));
  };
  double safe = 0.0;
  double unsafe = 1.0;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = 0.5 * (safe + unsafe);
    (keeps_clear(between(middle)) ? safe : unsafe) = middle;
  }
  const Velocity slowed = between(safe);
  const bool creep_mode = exact::hypot(slowed.vx, slowed.vy) < kStandStill && std::abs(slowed.omega) < kStandStill;
  return creep_mode && fallback == Velocity{} ? Velocity{} : slowed;
}

double sight_of_decision(const GateModel& model, const GateState& state) {
  const Limits& limits = model.limits;
  const auto fastest = [](double last, double acceleration, double limit) {
    return std::max(last, std::min(last + acceleration * kPeriod, limit));
  };
  const Velocity& last = state.last();
  const Velocity command{.vx = fastest(exact::hypot(last.vx, last.vy), limits.linear_acceleration, limits.linear),
                         .omega = fastest(std::abs(last.omega), limits.angular_acceleration, limits.angular)};
  const double way = way_of_pending(model, state) + way_to_stand_still(model, last, command);
  return model.footprint.circumscribed_radius() + model.margin + way + kRounding;
}

}  // namespace threewe::safety
