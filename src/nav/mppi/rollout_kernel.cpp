// A vector holds one quantity of as many samples as it has lanes, all of a sample's quantities in registers, in one
// pass over time. Sixteen samples are a block on every machine, so that sums over them have one order.
#include <algorithm>
#include <cassert>

#include "core/exact.hpp"
#include "nav/mppi/rollout.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nav/mppi/rollout_kernel.cpp"
#include "core/highway-inl.hpp"
//
#include "core/exact_exp-inl.hpp"
#include "nav/mppi/critics/goal-inl.hpp"
#include "nav/mppi/critics/heading-inl.hpp"
#include "nav/mppi/critics/obstacle-inl.hpp"
#include "nav/mppi/critics/path-inl.hpp"
#include "nav/mppi/critics/people-inl.hpp"
#include "nav/mppi/critics/smoothness-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace threewe::nav::mppi::HWY_NAMESPACE {

// The noise of a sample in its block, row by row.
struct Noise {
  const float* vx;
  const float* vy;
  const float* omega;
};

HWY_INLINE Noise noise_of(const Motion& motion, const Block& block, std::size_t lane) {
  return {motion.noise + block.row[0] * kBlock + lane, motion.noise + block.row[1] * kBlock + lane,
          motion.noise + block.row[2] * kBlock + lane};
}

// How far the samples deviate from their mean at one step.
struct Deviation {
  V vx;
  V vy;
  V omega;
};

HWY_INLINE Deviation deviation_of(const Motion& motion, const Block& block, const Noise& noise, std::size_t step) {
  const V vx = hn::Mul(hn::LoadU(kFloats, noise.vx + step * kBlock), number(block.scale[0]));
  const V omega = hn::Mul(hn::LoadU(kFloats, noise.omega + step * kBlock), number(block.scale[2]));
  V vy = hn::Zero(kFloats);
  if (motion.reach.holonomic) vy = hn::Mul(hn::LoadU(kFloats, noise.vy + step * kBlock), number(block.scale[1]));
  return {vx, vy, omega};
}

// What was asked for, as far as the limits allow it within a step.
HWY_INLINE void accelerate(const Reach& reach, V vx, V vy, V omega, Sample& at) {
  const V turn = number(reach.angular_acceleration);
  const V fastest = number(reach.angular);
  omega = clamp(omega, hn::Neg(fastest), fastest);
  at.omega = clamp(omega, hn::Sub(at.omega, turn), hn::Add(at.omega, turn));

  const V speeding = number(reach.acceleration);
  const V braking = number(reach.braking);
  if (reach.holonomic) {
    const V asked = length(vx, vy);
    const V most = hn::Min(number(reach.linear), hn::Add(at.speed, speeding));
    at.speed = hn::Min(asked, most);
    const V share = hn::Div(at.speed, hn::Max(asked, number(1e-6F)));
    at.vx = clamp(hn::Mul(share, vx), hn::Sub(at.vx, braking), hn::Add(at.vx, braking));
    at.vy = clamp(hn::Mul(share, vy), hn::Sub(at.vy, braking), hn::Add(at.vy, braking));
  } else {
    const V zero = hn::Zero(kFloats);
    const V most = hn::Max(hn::Add(at.vx, speeding), hn::Min(hn::Add(at.vx, braking), zero));
    const V least = hn::Min(hn::Sub(at.vx, speeding), hn::Max(hn::Sub(at.vx, braking), zero));
    vx = clamp(vx, number(-reach.backward), number(reach.linear));
    at.vx = clamp(vx, least, most);
    at.speed = hn::Abs(at.vx);
  }
}

// The way of one step, along its mean heading. Turns of a step are small.
HWY_INLINE void move(float dt, Sample& at) {
  const V turn = hn::Mul(at.omega, number(dt));
  const V square = squared(turn);
  const V c = hn::Sub(number(1.0F), hn::Mul(square, hn::Sub(number(0.5F), hn::Mul(square, number(1.0F / 24.0F)))));
  const V s = hn::Mul(turn, hn::Sub(number(1.0F), hn::Mul(square, number(1.0F / 6.0F))));
  const V cos = hn::Sub(hn::Mul(at.cos, c), hn::Mul(at.sin, s));
  const V sin = hn::Add(hn::Mul(at.sin, c), hn::Mul(at.cos, s));
  const V half = number(0.5F * dt);
  const V mean_cos = hn::Mul(half, hn::Add(at.cos, cos));
  const V mean_sin = hn::Mul(half, hn::Add(at.sin, sin));
  at.x = hn::Add(at.x, hn::Sub(hn::Mul(mean_cos, at.vx), hn::Mul(mean_sin, at.vy)));
  at.y = hn::Add(at.y, hn::Add(hn::Mul(mean_sin, at.vx), hn::Mul(mean_cos, at.vy)));
  at.theta = hn::Add(at.theta, turn);
  at.cos = cos;
  at.sin = sin;
}

HWY_INLINE Sample begin(const Start& start) {
  const V vx = number(start.vx);
  const V vy = number(start.vy);
  return {number(start.x),     number(start.y), number(start.cos), number(start.sin), number(start.theta), vx, vy,
          number(start.omega), length(vx, vy)};
}

// A vector of samples from the beginning of their plans to the end.
HWY_INLINE V cost_of(const Problem& problem, const Block& block, std::size_t lane) {
  const Plan& mean = problem.means[block.mean];
  const Noise noise = noise_of(problem, block, lane);
  Sample at = begin(problem.start);
  Progress progress;
  look_at_path(problem.path.path, at.x, at.y, number(problem.start.progress), progress);
  V cost = hn::Zero(kFloats);
  for (std::size_t step = 0; step < kSteps; ++step) {
    const auto [nx, ny, nw] = deviation_of(problem, block, noise, step);
    V control = hn::Add(hn::Mul(nx, number(mean.vx[step] * problem.per_variance[0])),
                        hn::Mul(nw, number(mean.omega[step] * problem.per_variance[2])));
    control = hn::Add(control, hn::Mul(ny, number(mean.vy[step] * problem.per_variance[1])));
    cost = hn::Add(cost, control);

    const Sample before = at;
    accelerate(problem.reach, hn::Add(nx, number(mean.vx[step])), hn::Add(ny, number(mean.vy[step])),
               hn::Add(nw, number(mean.omega[step])), at);
    move(problem.reach.dt, at);
    cost = hn::Add(cost, smoothness_cost(problem.smoothness, before, at));

    if (step % kLook != kLook - 1) continue;
    const float seconds = static_cast<float>(step + 1) * problem.reach.dt;
    cost = hn::Add(cost, obstacle_cost(problem.obstacle, at));
    cost = hn::Add(cost, direction_cost(problem.heading, at));
    if (problem.people.count > 0) cost = hn::Add(cost, people_cost(problem.people, at, seconds));

    if (step % kLookFar != kLookFar - 1) continue;
    cost = hn::Add(cost, path_cost(problem.path, at, progress));
    cost = hn::Add(cost, heading_cost(problem.heading, at, progress));
    cost = hn::Add(cost, goal_cost(problem.goal, at));
  }
  return hn::Add(cost, rest_cost(problem.goal, at));
}

void roll_out_all(const Problem& problem, std::span<const Block> blocks, float* costs) {
  for (const Block& block : blocks) {
    for (std::size_t lane = 0; lane < kBlock; lane += hn::Lanes(kFloats)) {
      hn::StoreU(cost_of(problem, block, lane), kFloats, costs + lane);
    }
    costs += kBlock;
  }
}

// As `cost_of`, without the prices.
void trace_all(const Motion& motion, const Block& block, Traces& traces) {
  const Plan& mean = motion.means[block.mean];
  for (std::size_t lane = 0; lane < kBlock; lane += hn::Lanes(kFloats)) {
    const Noise noise = noise_of(motion, block, lane);
    Sample at = begin(motion.start);
    for (std::size_t step = 0; step < kSteps; ++step) {
      const auto [nx, ny, nw] = deviation_of(motion, block, noise, step);
      const V vx = hn::Add(nx, number(mean.vx[step]));
      const V vy = motion.reach.holonomic ? hn::Add(ny, number(mean.vy[step])) : ny;
      const V omega = hn::Add(nw, number(mean.omega[step]));
      accelerate(motion.reach, vx, vy, omega, at);
      move(motion.reach.dt, at);
      const std::size_t i = step * kBlock + lane;
      hn::StoreU(vx, kFloats, traces.vx.data() + i);
      hn::StoreU(vy, kFloats, traces.vy.data() + i);
      hn::StoreU(omega, kFloats, traces.omega.data() + i);
      hn::StoreU(at.x, kFloats, traces.x.data() + i);
      hn::StoreU(at.y, kFloats, traces.y.data() + i);
      hn::StoreU(at.theta, kFloats, traces.theta.data() + i);
    }
  }
}

void weigh_all(std::span<float> costs, float per_temperature) {
  const float least = *std::min_element(costs.begin(), costs.end());
  for (std::size_t i = 0; i < costs.size(); i += hn::Lanes(kFloats)) {
    const V excess = hn::Mul(hn::Sub(hn::LoadU(kFloats, costs.data() + i), number(least)), number(per_temperature));
    const V weight = exact::HWY_NAMESPACE::exp(kFloats, hn::Neg(hn::Min(excess, number(kNegligible))));
    hn::StoreU(hn::IfThenElseZero(hn::Lt(excess, number(kNegligible)), weight), kFloats, costs.data() + i);
  }
}

// The sum over all samples of weight times scaled noise, step by step; 16 partial sums.
void add_noise(const Problem& problem, std::span<const Block> blocks, const float* weights, NoiseSums& sums) {
  for (const Block& block : blocks) {
    const float* weight = weights;
    weights += kBlock;
    if (std::all_of(weight, weight + kBlock, [](float w) { return w == 0.0F; })) continue;
    for (std::size_t lane = 0; lane < kBlock; lane += hn::Lanes(kFloats)) {
      const V w = hn::LoadU(kFloats, weight + lane);
      for (std::size_t c = 0; c < 3; ++c) {
        const V share = hn::Mul(w, number(block.scale[c]));
        const float* noise = problem.noise + block.row[c] * kBlock + lane;
        float* sum = sums[c].data() + lane;
        for (std::size_t step = 0; step < kSteps; ++step) {
          const V more = hn::Mul(share, hn::LoadU(kFloats, noise + step * kBlock));
          hn::StoreU(hn::Add(hn::LoadU(kFloats, sum + step * kBlock), more), kFloats, sum + step * kBlock);
        }
      }
    }
  }
}

}  // namespace threewe::nav::mppi::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace threewe::nav::mppi {
namespace {

HWY_EXPORT(roll_out_all);
HWY_EXPORT(trace_all);
HWY_EXPORT(weigh_all);
HWY_EXPORT(add_noise);

}  // namespace

void roll_out(const Problem& problem, std::span<const Block> blocks, std::span<float> costs) {
  assert(costs.size() == blocks.size() * kBlock);
  HWY_DYNAMIC_DISPATCH(roll_out_all)(problem, blocks, costs.data());
}

void trace(const Motion& motion, const Block& block, Traces& traces) {
  HWY_DYNAMIC_DISPATCH(trace_all)(motion, block, traces);
}

Plan average(const Problem& problem, std::span<const Block> blocks, std::span<float> costs, float temperature) {
  assert(!costs.empty() && costs.size() == blocks.size() * kBlock);
  HWY_DYNAMIC_DISPATCH(weigh_all)(costs, 1.0F / temperature);
  NoiseSums sums{};
  HWY_DYNAMIC_DISPATCH(add_noise)(problem, blocks, costs.data(), sums);

  // how much of the weight each mean has
  std::array<float, kMeans> shares{};
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    shares[blocks[i].mean] = shares[blocks[i].mean] + exact::sum(costs.subspan(i * kBlock, kBlock));
  }
  float total = 0.0F;
  for (const float share : shares) total = total + share;

  Plan plan;
  const std::array<std::array<float, kSteps> Plan::*, 3> components = {&Plan::vx, &Plan::vy, &Plan::omega};
  for (std::size_t c = 0; c < components.size(); ++c) {
    for (std::size_t step = 0; step < kSteps; ++step) {
      float sum = exact::sum(std::span<const float>(sums[c]).subspan(step * kBlock, kBlock));
      for (std::size_t m = 0; m < kMeans; ++m) sum = sum + shares[m] * (problem.means[m].*components[c])[step];
      (plan.*components[c])[step] = sum / total;
    }
  }
  return plan;
}

}  // namespace threewe::nav::mppi
#endif
