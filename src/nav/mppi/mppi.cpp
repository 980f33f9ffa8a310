#include "nav/mppi.hpp"

#include <algorithm>
#include <cmath>

#include "core/exact.hpp"
#include "hardware/limits.hpp"
#include "nav/mppi/noise.hpp"
#include "nav/mppi/obstacle_field.hpp"
#include "nav/mppi/path_table.hpp"
#include "nav/mppi/pursuit.hpp"
#include "nav/mppi/rollout.hpp"
#include "nav/polyline.hpp"
#include "safety/params.hpp"
#include "threewe/core/time.hpp"

namespace threewe::nav {
namespace {

using mppi::kSteps;
using mppi::Plan;

constexpr double kPeriod = to_seconds(kControlPeriod);
constexpr std::uint32_t kOtherMeans = 2;  // stand still, and pursue the path

float narrow(double x) { return static_cast<float>(x); }

// What is not known to be out of reach [m].
double reach_of(const RobotProfile& profile, const Params& params) {
  return profile.operating_limits.linear * kSteps * params.mppi.step + 10.0 * params.follower.step;
}

// What is left of a plan after so many steps; it goes on as it ends.
Plan later(const Plan& plan, double steps) {
  Plan rest;
  for (std::size_t i = 0; i < kSteps; ++i) {
    const double at = std::min(static_cast<double>(i) + steps, kSteps - 1.0);
    const auto before = static_cast<std::size_t>(at);
    const std::size_t after = std::min(before + 1, kSteps - 1);
    const float share = narrow(at - static_cast<double>(before));
    for (auto component : {&Plan::vx, &Plan::vy, &Plan::omega}) {
      const auto& values = plan.*component;
      (rest.*component)[i] = values[before] + share * (values[after] - values[before]);
    }
  }
  return rest;
}

// Where the samples of a plan came from: they are rolled out once more for a caller that asks.
struct Origin {
  Time made{};
  Vec2 middle;  // of the window, in `odom`
  mppi::Motion motion;
  std::vector<mppi::Block> blocks;
};

// What the first `count` samples of a block ask for, and in `odom` where that leads.
void append_ways(const mppi::Motion& motion, const mppi::Block& block, std::size_t count, Vec2 middle,
                 std::vector<Velocity>& velocities, std::vector<Pose2D>& poses) {
  const auto wide = [](float x) { return static_cast<double>(x); };
  mppi::Traces traces;
  mppi::trace(motion, block, traces);
  for (std::size_t lane = 0; lane < count; ++lane) {
    for (std::size_t i = lane; i < traces.x.size(); i += mppi::kBlock) {
      velocities.emplace_back(wide(traces.vx[i]), wide(traces.vy[i]), wide(traces.omega[i]));
      const double theta = wrap_angle(wide(traces.theta[i]));
      poses.emplace_back(middle.x + wide(traces.x[i]), middle.y + wide(traces.y[i]), theta);
    }
  }
}

}  // namespace

struct Mppi::Impl {
  Params::Mppi params;
  mppi::PursuitParams pursuit;
  double encroachment;  // [m]
  std::uint64_t seed;
  Limits limits;
  Kinematics kinematics;
  Footprint footprint;
  double slack;  // [m] that the robot may move before the obstacle field is made anew
  double delay;  // [s] from a command to its effect
  double reach;  // [m]
  mppi::ObstacleField field;

  Plan plan;
  std::uint64_t tick = 0;
  std::vector<Velocity> commanded;  // the newest first, as many periods as the delay has
  std::vector<Vec2> obstacles;      // what the field was made of
  Pose2D start;                     // where the plan begins, in odom
  std::vector<MovingDisc> moving;
  std::optional<Time> last;  // when it was asked
  int followed = 0;          // periods since the plan was made
  mppi::PathTable path;
  std::vector<float> costs;  // of the samples, then how much each counts
  Origin origin;

  Impl(const RobotProfile& profile, const Params& all, std::uint64_t s)
      : params(all.mppi),
        pursuit{.lookahead = all.follower.faced,
                .rest = all.motion.path_end,
                .position_gain = all.follower.position_gain,
                .heading_gain = all.follower.heading_gain,
                .turn_first = all.follower.turn_first},
        encroachment(all.creep.encroachment),
        seed(s),
        limits(profile.operating_limits),
        kinematics(profile.kinematics()),
        footprint(profile.body.footprint),
        slack(2.5 * all.follower.step),
        delay(to_seconds(profile.command_latency + profile.body.motor_lag)),
        reach(reach_of(profile, all)),
        field(footprint, reach, params.obstacle_reach + safety::margin_of(profile), all),
        commanded(static_cast<std::size_t>(delay / kPeriod) + 1) {}

  void go_on(const MppiObservation& seen);
  bool is_due() const { return followed >= params.periods; }
  void predict_start(const Pose2D& odom_from_base);
  void see_obstacles(const MppiObservation& now, const MppiTask& task);
  std::pair<Vec2, Vec2> surroundings(const MppiTask& task) const;
  void lay_out(const MppiTask& task);
  void plan_anew(const MppiTask& task);
  std::array<float, 3> deviation() const;
  mppi::Problem pose_problem(const MppiTask& task) const;
  double free_margin(double wanted) const;
  void add_moving(mppi::PeopleCritic& critic) const;
  Velocity command() const;
};

Mppi::Mppi(const RobotProfile& profile, const Params& params, std::uint64_t seed)
    : impl_(std::make_unique<Impl>(profile, params, seed)) {}
Mppi::Mppi(const Mppi& other) : impl_(std::make_unique<Impl>(*other.impl_)) {}
Mppi& Mppi::operator=(const Mppi& other) {
  if (this != &other) impl_ = std::make_unique<Impl>(*other.impl_);
  return *this;
}
Mppi::Mppi(Mppi&&) noexcept = default;
Mppi& Mppi::operator=(Mppi&&) noexcept = default;
Mppi::~Mppi() = default;

Velocity Mppi::step(const MppiObservation& seen, const MppiTask& task) {
  Impl& me = *impl_;
  me.go_on(seen);
  if (me.is_due()) {
    me.predict_start(seen.odom_from_base);
    me.see_obstacles(seen, task);
    me.lay_out(task);
    me.plan_anew(task);
  }
  return me.command();
}

// A period has passed since. After a longer while nothing is known of what was commanded meanwhile: likely the same.
void Mppi::Impl::go_on(const MppiObservation& seen) {
  if (last && seen.now - *last == kControlPeriod) {
    std::rotate(commanded.begin(), commanded.end() - 1, commanded.end());
    commanded.front() = seen.commanded;
    ++followed;
  } else {
    std::ranges::fill(commanded, seen.commanded);
    followed = params.periods;
    plan = {};
  }
  last = seen.now;
}

// A variation of what is left of the plan before.
void Mppi::Impl::plan_anew(const MppiTask& task) {
  plan = later(plan, kPeriod / params.step * followed);
  followed = 0;
  const mppi::Problem problem = pose_problem(task);
  auto blocks = mppi::draw_blocks(params.samples, kOtherMeans, deviation(), seed, tick++);
  costs.resize(blocks.size() * mppi::kBlock);
  mppi::roll_out(problem, blocks, costs);
  plan = mppi::average(problem, blocks, costs, narrow(params.temperature));
  origin = {*last, field.middle(), problem, std::move(blocks)};
}

// Where the robot will be when the first command of the plan takes effect: it obeys earlier commands until then.
void Mppi::Impl::predict_start(const Pose2D& odom_from_base) {
  start = odom_from_base;
  double rest = delay;
  for (std::size_t i = commanded.size(); i-- > 0;) {
    const double seconds = std::clamp(rest - kPeriod * static_cast<double>(i), 0.0, kPeriod);
    start = integrate(start, commanded[i], seconds);
    rest -= seconds;
  }
}

// The field is made once per scan. What moves is no obstacle: it has a critic of its own.
void Mppi::Impl::see_obstacles(const MppiObservation& now, const MppiTask& task) {
  moving.assign(now.moving.begin(), now.moving.end());
  std::vector<Vec2> still;
  const double far = reach + params.obstacle_reach + footprint.circumscribed_radius();
  for (const Vec2 p : now.obstacles) {
    const auto is_part = [&](const MovingDisc& disc) {
      return distance(p, disc.position) <= disc.radius + params.people_blur;
    };
    if (distance(p, start.position()) <= far && std::ranges::none_of(moving, is_part)) still.push_back(p);
  }
  const auto [low, high] = surroundings(task);
  if (still == obstacles && distance(start.position(), field.middle()) < slack && field.covers(low, high)) return;
  obstacles = std::move(still);
  const Vec2 more{slack, slack};
  field.update(obstacles, start.position(), low - more, high + more);
}

// Two corners between which lie the next metres of the path, and what is beside it.
std::pair<Vec2, Vec2> Mppi::Impl::surroundings(const MppiTask& task) const {
  Vec2 low = start.position();
  Vec2 high = low;
  const auto include = [&](Vec2 p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  };
  if (!task.path.empty()) {
    const PathPoint here = nearest_on_path(task.path, start.position());
    const PathPoint end = place_after(task.path, here, reach);
    include(here.point);
    for (std::size_t i = here.piece + 1; i <= end.piece; ++i) include(task.path[i]);
    include(end.point);
  }
  const Vec2 stray{params.stray, params.stray};
  return {low - stray, high + stray};
}

void Mppi::Impl::lay_out(const MppiTask& task) {
  const Vec2 here = start.position();
  const std::array<Vec2, 1> stay = {here};
  path.lay_out(task.path.empty() ? std::span<const Vec2>(stay) : task.path, here, field.middle(), field.unit(), reach);
}

std::array<float, 3> Mppi::Impl::deviation() const {
  return {narrow(params.linear_noise), narrow(params.linear_noise), narrow(params.angular_noise)};
}

mppi::Problem Mppi::Impl::pose_problem(const MppiTask& task) const {
  const Params::Mppi::Weights& w = params.weights;
  const double dt = params.step;
  const double length = w.unit_of_length;
  const double speed = w.unit_of_speed;
  mppi::Problem p;
  p.reach = {.dt = narrow(dt),
             .linear = narrow(limits.linear),
             .backward = narrow(task.backwards ? limits.linear : params.backward_speed * limits.linear),
             .acceleration = narrow(limits.linear_acceleration * dt),
             .braking = narrow(limits.linear_braking * dt),
             .angular = narrow(limits.angular),
             .angular_acceleration = narrow(limits.angular_acceleration * dt),
             .holonomic = kinematics == Kinematics::holonomic};

  const Vec2 here = start.position() - field.middle();
  const auto [sin, cos] = exact::sincos(start.theta);
  p.start = {.x = narrow(here.x),
             .y = narrow(here.y),
             .cos = narrow(cos),
             .sin = narrow(sin),
             .theta = narrow(start.theta),
             .vx = narrow(commanded.front().vx),
             .vy = narrow(commanded.front().vy),
             .omega = narrow(commanded.front().omega)};
  p.means[0] = plan;
  p.means[2] = mppi::pursue(path, task, limits, kinematics, dt, start, pursuit);
  p.noise = mppi::noise_pool().data();

  const double corner = footprint.circumscribed_radius();
  const double by_speed = w.obstacle_braking / (2.0 * limits.linear_braking * length);  // [s^2/m^2]
  p.obstacle = {.field = field.view(),
                .margin = narrow(free_margin(task.margin)),
                .per_reach = narrow(1.0 / params.obstacle_reach),
                .contact = narrow(w.obstacle_contact),
                .depth = narrow(w.obstacle_depth / length),
                .close = narrow(w.obstacle_close),
                .close_speed = narrow(by_speed),
                .close_turn = narrow(by_speed * corner * corner)};
  const bool turning = task.turn.has_value();
  const bool resting = !turning && path.length() < pursuit.rest;
  p.path = {.path = path.view(),
            .left = narrow(turning ? 0.0 : w.path_left / speed),
            .beside = narrow(w.path_offset / (length * length))};
  const exact::SinCos aside = exact::sincos(task.aside + (task.backwards ? exact::kPi : 0.0));
  p.heading = {.along = narrow(turning || resting ? 0.0 : w.heading_along),
               .aside_cos = narrow(aside.cos),
               .aside_sin = narrow(aside.sin),
               .sideways = narrow(turning ? 0.0 : w.heading_sideways / (speed * speed)),
               .sideways_free = narrow(params.sideways_free),
               .backward = narrow(w.heading_backward / (speed * speed)),
               .sign = task.backwards ? -1.0F : 1.0F,
               .turn = narrow(turning || resting ? w.heading_turn : 0.0),
               .turn_to = narrow(start.theta + task.turn.value_or(0.0))};
  if (path.ends()) {
    const Vec2 goal = path.end() - field.middle();
    p.goal = {.x = narrow(goal.x),
              .y = narrow(goal.y),
              .distance = narrow(w.path_left / speed),
              .speed = narrow(w.goal_speed / (speed * speed))};
  }
  p.smoothness = {.linear = narrow(w.smooth_linear / (speed * speed)), .angular = narrow(w.smooth_angular)};
  add_moving(p.people);

  // lambda times u' Sigma^-1 e of the update's derivation, in part
  const double share = params.control_cost * params.temperature;
  const double linear = params.linear_noise * params.linear_noise;
  const double angular = params.angular_noise * params.angular_noise;
  p.per_variance = {narrow(share / linear), narrow(share / linear), narrow(share / angular)};
  return p;
}

// The margin that is wanted or, where something is nearer already, what is left of it.
double Mppi::Impl::free_margin(double wanted) const {
  const Pose2D base_from_odom = inverse(start);
  const double far = footprint.circumscribed_radius() + wanted + encroachment;
  double least = wanted + encroachment;
  for (const Vec2 p : obstacles) {
    const Vec2 d = p - start.position();
    if (dot(d, d) <= far * far) least = std::min(least, footprint.signed_distance(base_from_odom * p));
  }
  return std::clamp(least - encroachment, 0.0, wanted);
}

// The nearest of them, where they will be when the plan begins.
void Mppi::Impl::add_moving(mppi::PeopleCritic& critic) const {
  std::vector<MovingDisc> nearest = moving;
  std::stable_sort(nearest.begin(), nearest.end(), [&](const MovingDisc& a, const MovingDisc& b) {
    return distance(a.position, start.position()) < distance(b.position, start.position());
  });
  critic.count = std::min(nearest.size(), mppi::kPeople);
  critic.per_reach = narrow(1.0 / params.people_reach);
  critic.contact = narrow(params.weights.people_contact / params.weights.unit_of_speed);
  critic.close = narrow(params.weights.people_close / params.weights.unit_of_speed);
  for (std::size_t i = 0; i < critic.count; ++i) {
    const MovingDisc& disc = nearest[i];
    const Vec2 at = disc.position + delay * disc.velocity - field.middle();
    critic.x[i] = narrow(at.x);
    critic.y[i] = narrow(at.y);
    critic.vx[i] = narrow(disc.velocity.x);
    critic.vy[i] = narrow(disc.velocity.y);
    critic.apart[i] = narrow(disc.radius + footprint.circumscribed_radius());
  }
}

// What the plan wants now, as far as one period allows it.
Velocity Mppi::Impl::command() const {
  const double at = std::min(kPeriod / params.step * followed, kSteps - 2.0);
  const auto before = static_cast<std::size_t>(at);
  const double share = at - static_cast<double>(before);
  const Velocity a{plan.vx[before], plan.vy[before], plan.omega[before]};
  const Velocity b{plan.vx[before + 1], plan.vy[before + 1], plan.omega[before + 1]};
  Velocity wanted{a.vx + share * (b.vx - a.vx), a.vy + share * (b.vy - a.vy), a.omega + share * (b.omega - a.omega)};
  if (kinematics == Kinematics::differential) wanted.vy = 0.0;
  return within_acceleration(limits, commanded.front(), within_limits(limits, wanted));
}

std::optional<SampledPlan> Mppi::plan(Time now) const {
  const Impl& me = *impl_;
  if (me.last != now) return {};
  SampledPlan plan{.made = me.origin.made, .step = me.params.step};

  // the plan itself is a sample without noise
  mppi::Motion motion = me.origin.motion;
  motion.means[0] = me.plan;
  append_ways(motion, {}, 1, me.origin.middle, plan.velocities, plan.poses);
  for (const mppi::Block& block : me.origin.blocks) {
    append_ways(me.origin.motion, block, mppi::kBlock, me.origin.middle, plan.controls, plan.trajectories);
  }
  double total = 0.0;
  for (const float weight : me.costs) total += static_cast<double>(weight);
  for (const float weight : me.costs) plan.weights.push_back(static_cast<double>(weight) / total);
  return plan;
}

}  // namespace threewe::nav
