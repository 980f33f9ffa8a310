// What robots observe.
#include <algorithm>
#include <array>

#include "env/batch_impl.hpp"
#include "env/checks.hpp"
#include "env/observations.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::env {

void Batch::Impl::observe(std::size_t world, std::vector<Array>& arrays, std::size_t part) {
  std::vector<task::Belief>& beliefs = scratch[part].beliefs;
  for (std::size_t robot = 0; robot < options.robots; ++robot) {
    beliefs[robot] = belief_of(world, robot, part);
    task->update(world, beliefs[robot]);
  }
  for (std::size_t robot = 0; robot < options.robots; ++robot) {
    const std::size_t i = row(world, robot);
    const sim::RobotState& state = states[i];
    auto array = arrays.begin();
    const auto next = [&](bool wanted) { return wanted ? (array++)->row(i) : std::span<std::byte>(); };
    const auto color = next(options.observed.image);
    const auto depth = next(options.observed.depth);
    if (!color.empty() || !depth.empty()) {
      episodes[world].pictures.draw(model_of(world), robot, state, color, depth, scratch[part].drawing);
    }
    put_scan(beliefs[robot].scan, next(options.observed.lidar));
    const Pose2D& pose = beliefs[robot].map_from_base;
    put({pose.x, pose.y, pose.theta}, next(options.observed.pose));
    const Velocity velocity = agents[i].velocity(agent_model, state);
    put({velocity.vx, velocity.vy, velocity.omega}, next(options.observed.velocity));

    std::array<std::span<std::byte>, kMostTaskFields> fields;
    for (std::size_t field = 0; field < task_fields.size(); ++field) fields[field] = next(task_fields[field]);
    task->observe(world, robot, beliefs[robot], std::span(fields).first(task_fields.size()));

    const std::array<double, 3> truth{state.pose.x, state.pose.y, state.pose.theta};
    std::ranges::copy(truth, true_poses.begin() + static_cast<std::ptrdiff_t>(3 * i));
    scan_ages[i] = agents[i].scan_age(state.time());
  }
}

task::Belief Batch::Impl::belief_of(std::size_t world, std::size_t robot, std::size_t part) {
  const std::size_t i = row(world, robot);
  task::Belief belief;
  belief.map_from_base = agents[i].map_from_base(agent_model, states[i]);
  if (robot > 0) {  // a team knows where it set out
    belief.map_from_base = inverse(states[row(world)].start) * states[i].start * belief.map_from_base;
  }
  if (agent_model.profile.lidar) {
    belief.scan = agents[i].scan(agent_model, scratch[part].scans[robot]);
    belief.base_from_lidar = agent_model.profile.lidar->base_from_lidar;
    belief.range_max = agent_model.profile.lidar->range_max;
  }
  return belief;
}

TopView Batch::Impl::top_view(std::size_t world) const {
  const Episode& episode = episodes.at(world);
  if (!episode.begun) throw ContractError("there is nothing to see before the first reset()");
  TopView view;
  for (std::size_t i = row(world); i < row(world + 1); ++i) {
    view.robots.push_back(states[i].pose);
    view.hits.push_back(transformed(states[i].pose, agents[i].hits(agent_model, states[i])));
  }
  view.people = sim::circles_of(model_of(world), episode.people);
  view.task = task->debug_overlay(world);
  return view;
}

}  // namespace threewe::env
