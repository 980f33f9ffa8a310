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
#include "threewe/core/time.hpp"

namespace threewe::nav {
namespace {

using mppi::kSteps;
using mppi::Plan;

constexpr double kPeriod = to_seconds(kControlPeriod);
constexpr double kBackward = 0.5;         // share of its speed that a differential base may drive backwards
constexpr double kRest = 0.05;            // [m] so near the end of its path the robot keeps its heading
constexpr double kLine = 50.0;            // times as dear is it to leave a line that is to be kept
constexpr std::uint32_t kOtherMeans = 2;  // stand still, and pursue the path
constexpr double kStray = 0.35;           // [m] beside its path that a plan may lead with its eyes open
constexpr double kAstray = 0.05;          // [m] more, so that the obstacle field need not be made anew each time
constexpr double kNotNearer = 0.005;      // [m] what is nearer than the margin may come so much nearer, no more

float narrow(double x) { return static_cast<float>(x); }

// What is not known to be out of reach [m].
double reach_of(const RobotProfile& profile, const MppiSettings& settings) {
  return profile.operating_limits.linear * kSteps * settings.step + 0.2;
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

// Where the samples of a plan came from: they are rolled out once more for whoever asks.
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
  MppiSettings settings;
  Limits limits;
  Kinematics kinematics;
  Footprint footprint;
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

  Impl(const RobotProfile& profile, const MppiSettings& s)
      : settings(s),
        limits(profile.operating_limits),
        kinematics(profile.kinematics()),
        footprint(profile.body.footprint),
        delay(to_seconds(profile.command_latency + profile.body.motor_lag)),
        reach(reach_of(profile, s)),
        field(footprint, reach, s.obstacle_reach + profile.margin()),
        commanded(static_cast<std::size_t>(delay / kPeriod) + 1) {}

  void go_on(const MppiObservation& seen);
  bool is_due() const { return followed >= settings.periods; }
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

Mppi::Mppi(const RobotProfile& profile, const MppiSettings& settings)
    : impl_(std::make_unique<Impl>(profile, settings)) {}
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
    followed = settings.periods;
    plan = {};
  }
  last = seen.now;
}

// A variation of what is left of the plan before.
void Mppi::Impl::plan_anew(const MppiTask& task) {
  plan = later(plan, kPeriod / settings.step * followed);
  followed = 0;
  const mppi::Problem problem = pose_problem(task);
  auto blocks = mppi::draw_blocks(settings.samples, kOtherMeans, deviation(), settings.seed, tick++);
  costs.resize(blocks.size() * mppi::kBlock);
  mppi::roll_out(problem, blocks, costs);
  plan = mppi::average(problem, blocks, costs, narrow(settings.temperature));
  origin = {*last, field.middle(), problem, std::move(blocks)};
}

// Where the robot will be when the first command of the plan takes effect: it obeys until then what it was told before.
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
  const double far = reach + settings.obstacle_reach + footprint.circumscribed_radius();
  for (const Vec2 p : now.obstacles) {
    const auto is_part = [p](const MovingDisc& disc) { return distance(p, disc.position) <= disc.radius + 0.05; };
    if (distance(p, start.position()) <= far && std::ranges::none_of(moving, is_part)) still.push_back(p);
  }
  const auto [low, high] = surroundings(task);
  if (still == obstacles && distance(start.position(), field.middle()) < kAstray && field.covers(low, high)) return;
  obstacles = std::move(still);
  const Vec2 more{kAstray, kAstray};
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
  const Vec2 stray{kStray, kStray};
  return {low - stray, high + stray};
}

void Mppi::Impl::lay_out(const MppiTask& task) {
  const Vec2 here = start.position();
  const std::array<Vec2, 1> stay = {here};
  path.lay_out(task.path.empty() ? std::span<const Vec2>(stay) : task.path, here, field.middle(), field.unit(), reach);
}

std::array<float, 3> Mppi::Impl::deviation() const {
  return {narrow(settings.linear_noise), narrow(settings.linear_noise), narrow(settings.angular_noise)};
}

mppi::Problem Mppi::Impl::pose_problem(const MppiTask& task) const {
  const MppiWeights& w = settings.weights;
  const double dt = settings.step;
  mppi::Problem p;
  p.reach = {.dt = narrow(dt),
             .linear = narrow(limits.linear),
             .backward = narrow(task.backwards ? limits.linear : kBackward * limits.linear),
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
  p.means[2] = mppi::pursue(path, task, limits, kinematics, dt, start);
  p.noise = mppi::noise_pool().data();

  const double corner = footprint.circumscribed_radius();
  p.obstacle = {.field = field.view(),
                .margin = narrow(free_margin(task.margin)),
                .per_reach = narrow(1.0 / settings.obstacle_reach),
                .contact = narrow(w.obstacle_contact),
                .depth = narrow(w.obstacle_depth),
                .close = narrow(w.obstacle_close),
                .close_speed = narrow(w.obstacle_speed),
                .close_turn = narrow(w.obstacle_speed * corner * corner)};
  const bool turning = task.turn.has_value();
  const bool resting = !turning && path.length() < kRest;
  p.path = {.path = path.view(),
            .left = narrow(turning ? 0.0 : w.path_left),
            .beside = narrow((task.keep_line ? kLine : 1.0) * w.path_beside)};
  const exact::SinCos aside = exact::sincos(task.aside + (task.backwards ? exact::kPi : 0.0));
  p.heading = {.along = narrow(turning || resting ? 0.0 : w.heading_along),
               .aside_cos = narrow(aside.cos),
               .aside_sin = narrow(aside.sin),
               .sideways = narrow(turning ? 0.0 : w.heading_sideways),
               .sideways_free = narrow(settings.sideways_free),
               .backward = narrow(w.heading_backward),
               .sign = task.backwards ? -1.0F : 1.0F,
               .turn = narrow(turning || resting ? w.heading_turn : 0.0),
               .turn_to = narrow(start.theta + task.turn.value_or(0.0))};
  if (path.ends()) {
    const Vec2 goal = path.end() - field.middle();
    p.goal = {
        .x = narrow(goal.x), .y = narrow(goal.y), .distance = narrow(w.goal_distance), .speed = narrow(w.goal_speed)};
  }
  p.smoothness = {.linear = narrow(w.smooth_linear), .angular = narrow(w.smooth_angular)};
  add_moving(p.people);

  // lambda times u' Sigma^-1 e of the update's derivation, in part
  const double share = settings.control_cost * settings.temperature;
  const double linear = settings.linear_noise * settings.linear_noise;
  const double angular = settings.angular_noise * settings.angular_noise;
  p.per_variance = {narrow(share / linear), narrow(share / linear), narrow(share / angular)};
  return p;
}

// The margin that is wanted or, where something is nearer already, what is left of it.
double Mppi::Impl::free_margin(double wanted) const {
  const Pose2D base_from_odom = inverse(start);
  const double far = footprint.circumscribed_radius() + wanted + kNotNearer;
  double least = wanted + kNotNearer;
  for (const Vec2 p : obstacles) {
    const Vec2 d = p - start.position();
    if (dot(d, d) <= far * far) least = std::min(least, footprint.signed_distance(base_from_odom * p));
  }
  return std::clamp(least - kNotNearer, 0.0, wanted);
}

// The nearest of them, where they will be when the plan begins.
void Mppi::Impl::add_moving(mppi::PeopleCritic& critic) const {
  std::vector<MovingDisc> nearest = moving;
  std::stable_sort(nearest.begin(), nearest.end(), [&](const MovingDisc& a, const MovingDisc& b) {
    return distance(a.position, start.position()) < distance(b.position, start.position());
  });
  critic.count = std::min(nearest.size(), mppi::kPeople);
  critic.per_reach = narrow(1.0 / settings.people_reach);
  critic.contact = narrow(settings.weights.people_contact);
  critic.close = narrow(settings.weights.people_close);
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
  const double at = std::min(kPeriod / settings.step * followed, kSteps - 2.0);
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
  SampledPlan plan{.made = me.origin.made, .step = me.settings.step};

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
