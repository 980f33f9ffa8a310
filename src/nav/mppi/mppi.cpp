#include "threewe/nav/mppi.hpp"

#include <algorithm>
#include <cmath>

#include "nav/mppi/noise.hpp"
#include "nav/mppi/obstacle_field.hpp"
#include "nav/mppi/path_table.hpp"
#include "nav/mppi/pursuit.hpp"
#include "nav/mppi/rollout.hpp"
#include "threewe/core/time.hpp"
#include "threewe/hardware/limits.hpp"

namespace threewe::nav {
namespace {

using mppi::kSteps;
using mppi::Plan;

constexpr double kPeriod = to_seconds(kControlPeriod);
constexpr double kBackward = 0.5;         // share of its speed that a differential base may drive backwards
constexpr double kRest = 0.05;            // [m] so near the end of its path the robot keeps its heading
constexpr double kLine = 50.0;            // times as dear is it to leave a line that is to be kept
constexpr std::uint32_t kOtherMeans = 2;  // stand still, and pursue the path
constexpr double kAstray = 0.15;          // [m] from the middle of the obstacle field
constexpr double kNotNearer = 0.005;      // [m] what is nearer than the margin may come so much nearer, no more

float narrow(double x) { return static_cast<float>(x); }

// What is not known to be out of reach [m].
double reach_of(const RobotProfile& profile, const MppiSettings& settings) {
  return profile.operating_limits.linear * kSteps * settings.step + 0.2;
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
  std::vector<Vec2> seen;           // what the field was made of
  Pose2D start;                     // where the plan begins, in odom
  std::vector<Person> people;
  bool stepped = false;  // in the period before
  mppi::PathTable path;
  std::vector<float> costs;

  Impl(const RobotProfile& profile, const MppiSettings& s)
      : settings(s),
        limits(profile.operating_limits),
        kinematics(profile.kinematics()),
        footprint(profile.body.footprint),
        delay(to_seconds(profile.command_latency + profile.body.motor_lag)),
        reach(reach_of(profile, s)),
        field(footprint, reach, s.obstacle_reach + profile.margin()),
        commanded(static_cast<std::size_t>(delay / kPeriod) + 1) {}

  void predict_start(const MppiObservation& now);
  void see_obstacles(std::span<const Vec2> obstacles);
  void lay_out(const MppiTask& task);
  void shift_plan();
  std::array<float, 3> deviation() const;
  mppi::Problem pose_problem(const MppiTask& task) const;
  double free_margin(double wanted) const;
  void add_people(mppi::PeopleCritic& critic) const;
  Velocity take_first() const;
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

void Mppi::see(const MppiObservation& seen) {
  if (!impl_->stepped) impl_->plan = {};
  impl_->stepped = false;
  impl_->predict_start(seen);
  impl_->people.assign(seen.people.begin(), seen.people.end());
  impl_->see_obstacles(seen.obstacles);
}

Velocity Mppi::step(const MppiTask& task) {
  Impl& me = *impl_;
  me.lay_out(task);
  me.shift_plan();
  const mppi::Problem problem = me.pose_problem(task);
  const auto blocks = mppi::draw_blocks(me.settings.samples, kOtherMeans, me.deviation(), me.settings.seed, me.tick++);
  me.costs.resize(blocks.size() * mppi::kBlock);
  mppi::roll_out(problem, blocks, me.costs);
  me.plan = mppi::average(problem, blocks, me.costs, narrow(me.settings.temperature));
  me.stepped = true;
  return me.take_first();
}

// Where the robot will be when the first command of the plan takes effect: it obeys until then what it was told before.
void Mppi::Impl::predict_start(const MppiObservation& now) {
  std::rotate(commanded.begin(), commanded.end() - 1, commanded.end());
  commanded.front() = now.commanded;
  start = now.odom_from_base;
  double rest = delay;
  for (std::size_t i = commanded.size(); i-- > 0;) {
    const double seconds = std::clamp(rest - kPeriod * static_cast<double>(i), 0.0, kPeriod);
    start = integrate(start, commanded[i], seconds);
    rest -= seconds;
  }
}

// The field is made once per scan. People are no obstacles: they have a critic of their own.
void Mppi::Impl::see_obstacles(std::span<const Vec2> obstacles) {
  const bool same = std::equal(seen.begin(), seen.end(), obstacles.begin(), obstacles.end());
  if (same && distance(start.position(), field.middle()) < kAstray) return;
  seen.assign(obstacles.begin(), obstacles.end());
  std::vector<Vec2> still;
  const double far = reach + settings.obstacle_reach + footprint.circumscribed_radius();
  for (const Vec2 p : seen) {
    const auto is_part = [p](const Person& person) { return distance(p, person.position) <= person.radius + 0.05; };
    if (distance(p, start.position()) > far || std::any_of(people.begin(), people.end(), is_part)) continue;
    still.push_back(p);
  }
  field.update(still, start.position());
}

void Mppi::Impl::lay_out(const MppiTask& task) {
  const Vec2 here = start.position();
  const std::array<Vec2, 1> stay = {here};
  path.lay_out(task.path.empty() ? std::span<const Vec2>(stay) : task.path, here, field.middle(), field.unit(), reach);
}

// A period has passed since the plan was made, a part of a step.
void Mppi::Impl::shift_plan() {
  const float share = narrow(kPeriod / settings.step);
  for (auto component : {&Plan::vx, &Plan::vy, &Plan::omega}) {
    auto& values = plan.*component;
    for (std::size_t i = 0; i + 1 < kSteps; ++i) values[i] = values[i] + share * (values[i + 1] - values[i]);
  }
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
               .sideways = narrow(w.heading_sideways),
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
  add_people(p.people);

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
  for (const Vec2 p : seen) {
    const Vec2 d = p - start.position();
    if (dot(d, d) <= far * far) least = std::min(least, footprint.signed_distance(base_from_odom * p));
  }
  return std::clamp(least - kNotNearer, 0.0, wanted);
}

// The nearest of them, where they will be when the plan begins.
void Mppi::Impl::add_people(mppi::PeopleCritic& critic) const {
  std::vector<Person> nearest = people;
  std::stable_sort(nearest.begin(), nearest.end(), [&](const Person& a, const Person& b) {
    return distance(a.position, start.position()) < distance(b.position, start.position());
  });
  critic.count = std::min(nearest.size(), mppi::kPeople);
  critic.per_reach = narrow(1.0 / settings.people_reach);
  critic.contact = narrow(settings.weights.people_contact);
  critic.close = narrow(settings.weights.people_close);
  for (std::size_t i = 0; i < critic.count; ++i) {
    const Person& person = nearest[i];
    const Vec2 at = person.position + delay * person.velocity - field.middle();
    critic.x[i] = narrow(at.x);
    critic.y[i] = narrow(at.y);
    critic.vx[i] = narrow(person.velocity.x);
    critic.vy[i] = narrow(person.velocity.y);
    critic.apart[i] = narrow(person.radius + footprint.circumscribed_radius());
  }
}

// What the plan wants first, as far as one period allows it.
Velocity Mppi::Impl::take_first() const {
  Velocity wanted{plan.vx.front(), plan.vy.front(), plan.omega.front()};
  if (kinematics == Kinematics::differential) wanted.vy = 0.0;
  return within_acceleration(limits, commanded.front(), within_limits(limits, wanted));
}

std::vector<Pose2D> Mppi::predicted() const {
  std::vector<Pose2D> poses;
  Pose2D pose = impl_->start;
  for (std::size_t i = 0; i < kSteps; ++i) {
    pose = integrate(pose, {impl_->plan.vx[i], impl_->plan.vy[i], impl_->plan.omega[i]}, impl_->settings.step);
    poses.push_back(pose);
  }
  return poses;
}

}  // namespace threewe::nav
