#include "safety/collision_monitor.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "core/exact.hpp"
#include "draw.hpp"
#include "hardware/limits.hpp"
#include "safety/gate.hpp"

using namespace threewe;
using namespace threewe::safety;

namespace {

constexpr double kPeriod = to_seconds(kControlPeriod);

// The same decision, made by looking at every obstacle from every pose of the sweep.
class PlainMonitor {
 public:
  // The first so many obstacles are of a kind that may be nearer.
  PlainMonitor(const GateModel& model, const GateState& state, const std::vector<Vec2>& obstacles, std::size_t lesser)
      : model_(model),
        state_(state),
        obstacles_(obstacles),
        lesser_(lesser),
        required_(obstacles.size(), model.margin) {
    std::fill_n(required_.begin(), lesser, std::min(model.margin, model.creep.margin));
  }

  Velocity decide(const Velocity& command) {
    // what was commanded before, then braking
    std::vector<Pose2D> poses{{}};
    for (auto i = static_cast<std::size_t>(std::ceil(to_seconds(model_.reaction) / kPeriod - 1e-9)); i-- > 0;)
      drive(poses, state_.recent[i]);
    const Pose2D turning_point = poses.back();
    brake(poses, state_.last());
    for (std::size_t i = 0; i < obstacles_.size(); ++i) {
      for (const Pose2D& pose : poses) required_[i] = std::min(required_[i], clearance(pose, i));
    }
    settle(std::span(required_).first(lesser_), model_.bias);
    settle(std::span(required_).subspan(lesser_), 0.0);

    if (keeps_clear(turning_point, command)) return command;
    const Velocity fallback = braked(state_.last());
    if (fallback == Velocity{}) {  // who cannot even creep stays
      const double creeping = 1e-3 / std::max(std::hypot(command.vx, command.vy), std::abs(command.omega));
      const Velocity slowly{creeping * command.vx, creeping * command.vy, creeping * command.omega};
      if (creeping >= 1.0 || !keeps_clear(turning_point, slowly)) return {};
    }
    const auto between = [&](double t) {
      const Velocity& a = fallback;
      const Velocity& b = command;
      const Velocity v{a.vx + t * (b.vx - a.vx), a.vy + t * (b.vy - a.vy), a.omega + t * (b.omega - a.omega)};
      return within_acceleration(model_.limits, state_.last(), v);
    };
    double safe = 0.0;
    double half = 0.5;
    for (int i = 0; i < 10; ++i, half *= 0.5) {
      if (keeps_clear(turning_point, between(safe + half))) safe += half;
    }
    const Velocity slowed = between(safe);
    const bool creep_mode = std::hypot(slowed.vx, slowed.vy) < 1e-3 && std::abs(slowed.omega) < 1e-3;
    return creep_mode && fallback == Velocity{} ? Velocity{} : slowed;
  }

 private:
  // As exact as the velocities that it tells of.
  Velocity braked(const Velocity& v) const {
    const double time = std::max(exact::hypot(v.vx, v.vy) / model_.limits.linear_braking,
                                 std::abs(v.omega) / model_.limits.angular_acceleration);
    const double share = 1.0 - kPeriod / time;
    return time <= kPeriod ? Velocity{} : Velocity{share * v.vx, share * v.vy, share * v.omega};
  }

  // No corner goes farther than 5 mm from one pose to the next.
  void drive(std::vector<Pose2D>& poses, const Velocity& v) const {
    const double speed = std::hypot(v.vx, v.vy) + std::abs(v.omega) * model_.footprint.circumscribed_radius();
    const double steps = std::max(1.0, std::ceil(speed * kPeriod / model_.sweep_step - 1e-9));
    for (int i = 0; i < static_cast<int>(steps); ++i) poses.push_back(integrate(poses.back(), v, kPeriod / steps));
  }

  void brake(std::vector<Pose2D>& poses, Velocity v) const {
    while ((v = braked(v)) != Velocity{}) drive(poses, v);
  }

  // All of a kind may be as near as one of them is; those inside of the outline so deep.
  static void settle(std::span<double> required, double depth) {
    if (required.empty()) return;
    const double common = std::max(0.0, *std::ranges::min_element(required));
    for (double& one : required) {
      if (one < -1e-9) one = std::min(one, -depth);
      one = std::min(one, common) - 1e-9;
    }
  }

  double clearance(const Pose2D& pose, std::size_t obstacle) const {
    return model_.footprint.signed_distance(inverse(pose) * obstacles_[obstacle]);
  }

  bool keeps_clear(const Pose2D& from, const Velocity& v) const {
    std::vector<Pose2D> poses{from};
    drive(poses, v);
    brake(poses, v);
    for (const Pose2D& pose : poses) {
      for (std::size_t i = 0; i < obstacles_.size(); ++i) {
        if (clearance(pose, i) < required_[i]) return false;
      }
    }
    return true;
  }

  const GateModel& model_;
  const GateState& state_;
  const std::vector<Vec2>& obstacles_;
  std::size_t lesser_;
  std::vector<double> required_;
};

std::vector<GateModel> shipped_models() {
  std::vector<GateModel> models;
  for (const char* name : {"3we_standard_v2", "3we_base_v2", "3we_depth_v2", "turtlebot_like"})
    models.push_back(make_gate_model(load_profile(name)));
  return models;
}

Footprint random_footprint(Draw& draw) {
  if (draw.whole(0, 1) == 0) return Footprint::rectangle(draw(0.15, 0.6), draw(0.15, 0.5));
  // corners on an ellipse around the base
  const int corners = draw.whole(4, 9);
  const Vec2 axes{draw(0.1, 0.4), draw(0.1, 0.4)};
  std::vector<Vec2> outline;
  for (int i = 0; i < corners; ++i) {
    const double angle = (i + draw(0.0, 0.9)) * 2.0 * exact::kPi / corners;
    outline.push_back({axes.x * std::cos(angle), axes.y * std::sin(angle)});
  }
  return Footprint(outline);
}

GateModel random_model(Draw& draw) {
  static const std::vector<GateModel> shipped = shipped_models();
  if (draw.whole(0, 1) == 0) return shipped[static_cast<std::size_t>(draw.whole(0, 3))];
  GateModel model;
  model.kinematics = draw.whole(0, 1) == 0 ? Kinematics::holonomic : Kinematics::differential;
  model.limits = {.linear = draw(0.1, 1.5),
                  .angular = draw(0.3, 3.0),
                  .linear_acceleration = draw(0.3, 3.0),
                  .linear_braking = draw(0.5, 4.0),
                  .angular_acceleration = draw(1.0, 8.0)};
  model.footprint = random_footprint(draw);
  model.margin = draw(0.0, 0.1);
  model.bias = draw(0.0, 0.05);
  model.reaction = from_seconds(draw(0.0, 0.32));
  return model;
}

Velocity random_velocity(const GateModel& model, Draw& draw) {
  if (draw.whole(0, 4) == 0) return {};
  const Velocity shares{draw(-1.0, 1.0), draw(-1.0, 1.0), draw(-1.0, 1.0)};
  Velocity v = within_limits(model.limits, scaled_to(model.limits, shares));
  if (model.kinematics == Kinematics::differential || draw.whole(0, 2) == 0) v.vy = 0.0;
  if (draw.whole(0, 3) == 0) v.omega = 0.0;
  return v;
}

// Commands as they follow one another, or any.
GateState random_state(const GateModel& model, Draw& draw) {
  GateState state;
  const bool in_reach = draw.whole(0, 3) > 0;
  Velocity wanted;
  Velocity last;
  for (std::size_t i = 0; i < RecentCommands::kSize; ++i) {
    if (draw.whole(0, 5) == 0) wanted = random_velocity(model, draw);
    last = in_reach ? within_acceleration(model.limits, last, wanted) : wanted;
    state.recent.push(last);
  }
  return state;
}

// In, at, beside and far from the outline; alone and in rows.
std::vector<Vec2> random_obstacles(const GateModel& model, Draw& draw) {
  std::vector<Vec2> obstacles;
  const double room = model.footprint.circumscribed_radius() + draw(-0.1, 0.5);
  const bool may_touch = draw.whole(0, 2) == 0;
  const auto put = [&](Vec2 p) {
    if (may_touch || model.footprint.signed_distance(p) > 0.0) obstacles.push_back(p);
  };
  for (int i = draw.whole(0, 6); i > 0; --i) put(draw.point(-room, room));
  for (int i = draw.whole(0, 2); i > 0; --i) {
    const auto corners = std::span(model.footprint.corners());
    const auto at = static_cast<std::size_t>(draw.whole(0, static_cast<int>(corners.size()) - 1));
    put(draw(0.0, 1.0) * corners[at]);
    put(corners[at]);
    const Vec2 edge = corners[(at + 1) % corners.size()] - corners[at];
    put(corners[at] + draw(0.0, 1.0) * edge + draw(0.0, 0.3) * Vec2{edge.y, -edge.x});
  }
  for (int walls = draw.whole(0, 2); walls > 0; --walls) {
    const Vec2 from = draw.point(-room, room);
    const Vec2 step = draw.point(-0.05, 0.05);
    for (int i = 0; i < 20; ++i) put(from + static_cast<double>(i) * step);
  }
  return obstacles;
}

}  // namespace

TEST_CASE("what is beyond the sight of a decision changes none") {
  int close = 0;
  for (int seed = 0; seed < 20000; ++seed) {
    CAPTURE(seed);
    Draw draw(static_cast<std::uint64_t>(seed));
    const GateModel model = random_model(draw);
    const GateState state = random_state(model, draw);
    const double sight = sight_of_decision(model, state);
    std::vector<Vec2> beyond;
    for (int i = 0; i < 20; ++i) {
      const auto [s, c] = exact::sincos(draw(-exact::kPi, exact::kPi));
      beyond.push_back(sight * (1.0 + draw(0.0, 1.0) * draw(0.0, 0.02)) * Vec2{c, s});
    }
    const Obstacles obstacles{beyond, model.margin};
    const Velocity command = within_acceleration(model.limits, state.last(), random_velocity(model, draw));
    REQUIRE(clear_of_obstacles(model, state, command, std::span(&obstacles, 1), {}) == command);
    for (Vec2& point : beyond) point = 0.5 * point;  // it is no wide guess, either
    close += clear_of_obstacles(model, state, command, std::span(&obstacles, 1), {}) != command ? 1 : 0;
  }
  CHECK(close > 2000);
}

TEST_CASE("what looks at few poses decides as what looks at all of them") {
  int stopped = 0;
  int slowed = 0;
  constexpr int kCases = 20000;
  for (int seed = 0; seed < kCases; ++seed) {
    CAPTURE(seed);
    Draw draw(static_cast<std::uint64_t>(seed));
    const GateModel model = random_model(draw);
    const GateState state = random_state(model, draw);
    const Velocity command = within_acceleration(model.limits, state.last(), random_velocity(model, draw));
    const std::vector<Vec2> obstacles = random_obstacles(model, draw);
    const bool alike = seed % 2 == 0 || model.margin <= model.creep.margin;
    const std::size_t lesser = alike ? 0 : static_cast<std::size_t>(draw.whole(0, static_cast<int>(obstacles.size())));
    const auto kinds = [&](const std::vector<Vec2>& points) {
      const std::span<const Vec2> all(points);
      return std::array{Obstacles{all.first(lesser), std::min(model.margin, model.creep.margin), model.bias},
                        Obstacles{all.subspan(lesser), model.margin}};
    };
    const Velocity expected = PlainMonitor(model, state, obstacles, lesser).decide(command);
    REQUIRE(clear_of_obstacles(model, state, command, kinds(obstacles), {}) == expected);

    // seen from elsewhere, where rounding moves them by a hair
    const Pose2D base = draw.pose(-20.0, 20.0);
    const Velocity moved = clear_of_obstacles(model, state, command, kinds(transformed(base, obstacles)), base);
    const double off =
        std::hypot(moved.vx - expected.vx, moved.vy - expected.vy) + std::abs(moved.omega - expected.omega);
    REQUIRE(off == 0.0);
    (expected == Velocity{} ? stopped : slowed) += expected != command;
  }
  CHECK(stopped > kCases / 20);
  CHECK(slowed > kCases / 20);
}
