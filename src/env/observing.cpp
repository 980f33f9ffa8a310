// What robots observe.
#include <algorithm>
#include <array>

#include "core/exact.hpp"
#include "env/batch_impl.hpp"
#include "env/checks.hpp"
#include "env/observations.hpp"
#include "sim/step.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::env {

void Batch::Impl::observe(std::size_t world, std::vector<Array>& arrays, std::size_t part) {
  std::vector<task::Belief>& beliefs = scratch[part].beliefs;
  for (std::size_t robot = 0; robot < options.robots; ++robot) {
    update_belief(world, robot, beliefs[robot]);
    task->update(world, beliefs[robot]);
  }
  for (std::size_t robot = 0; robot < options.robots; ++robot) {
    const std::size_t i = row(world, robot);
    const sim::RobotState& state = states[i];
    auto array = arrays.begin();
    const auto next = [&](bool wanted) { return wanted ? (array++)->row(i) : std::span<std::byte>(); };
    if (options.observed.image || options.observed.depth) {
      const auto color = next(options.observed.image);
      const auto depth = next(options.observed.depth);
      episodes[world].pictures.draw(model_of(world), robot, state, color, depth, scratch[part].drawing);
    }
    if (options.observed.lidar) put_scan(beliefs[robot].scan, next(true));
    if (options.observed.pose) {
      const Pose2D& pose = beliefs[robot].map_from_base;
      put({pose.x, pose.y, pose.theta}, next(true));
    }
    if (options.observed.velocity) {
      const Velocity velocity = agents[i].velocity(agent_model, state);
      put({velocity.vx, velocity.vy, velocity.omega}, next(true));
    }

    std::array<std::span<std::byte>, kMostTaskFields> rows;  // NOLINT: what is used is filled
    for (std::size_t field = 0; field < task_fields.size(); ++field) rows[field] = next(task_fields[field]);
    task->observe(world, robot, beliefs[robot], std::span(rows).first(task_fields.size()));

    true_poses[3 * i] = state.pose.x;
    true_poses[3 * i + 1] = state.pose.y;
    true_poses[3 * i + 2] = state.pose.theta;
  }
}

// What does not stay the same from world to world.
void Batch::Impl::update_belief(std::size_t world, std::size_t robot, task::Belief& belief) const {
  const std::size_t i = row(world, robot);
  if (agent_model.localizes) belief.map_from_base = agents[i].map_from_base(agent_model, states[i]);
  if (agent_model.localizes && robot > 0) {  // a team knows where it set out
    belief.map_from_base = inverse(states[row(world)].start) * states[i].start * belief.map_from_base;
  }
  if (clock.scans) belief.scan = agents[i].scan();
}

// [s] since the newest scan that has arrived was complete, whether anything reads it or not.
double Batch::Impl::scan_age(const sim::RobotState& state) const {
  if (clock.turn == 0) return 0.0;
  const Duration turn = static_cast<Duration::rep>(clock.turn) * sim::kStep;
  const Duration latency = sim::varied_latency(options.hardware.lidar->latency, state.variation);
  const Time end = (state.time() - latency) / turn * turn;
  return end > Time::zero() ? to_seconds(state.time() - end) : 0.0;
}

// [m] what stands around a robot's lidar now, in the scene's frame: where no scans are made, which would tell.
std::vector<Vec2> Batch::Impl::hits_around(std::size_t world, std::size_t robot) const {
  std::vector<Vec2> hits;
  if (!options.hardware.lidar) return hits;
  const LidarSpec& spec = *options.hardware.lidar;
  std::vector<float> ranges(static_cast<std::size_t>(spec.beams));
  const Pose2D lidar = states[row(world, robot)].pose * spec.base_from_lidar;
  const auto legs = sim::legs_of(model_of(world), episodes[world].people);
  const double increment = 2.0 * exact::kPi / spec.beams;
  model_of(world).robots[robot].caster->cast(lidar, 0.0, increment, ranges, {{}, legs});
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const auto range = double{ranges[i]};
    if (range < spec.range_max) hits.push_back(lidar * rotate({range, 0.0}, static_cast<double>(i) * increment));
  }
  return hits;
}

TopView Batch::Impl::top_view(std::size_t world) const {
  const Episode& episode = episodes.at(world);
  if (!episode.begun) throw ContractError("there is nothing to see before the first reset()");
  TopView view;
  for (std::size_t i = row(world); i < row(world + 1); ++i) {
    view.robots.push_back(states[i].pose);
    view.hits.push_back(clock.scans ? transformed(states[i].pose, agents[i].hits(agent_model, states[i]))
                                    : hits_around(world, i - row(world)));
  }
  view.people = sim::circles_of(model_of(world), episode.people);
  view.task = task->debug_overlay(world);
  return view;
}

}  // namespace threewe::env
