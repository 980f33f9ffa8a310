#include "threewe/env/batch.hpp"

#include <algorithm>
#include <array>
#include <new>
#include <utility>

#include <fmt/format.h>

#include "env/batch_impl.hpp"
#include "env/checks.hpp"
#include "env/exclusive_use.hpp"
#include "env/observations.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::env {

Batch::Impl::Impl(Options wanted)
    : options(checked(std::move(wanted))),
      places(make_places(options)),
      task(options.task({places.tables, options.worlds, options.robots, options.hardware, options.control_period})),
      fields(observation_fields(options, task->fields())),
      task_fields(which_are_among(fields, task->fields())),
      clock(make_clock(options, places.models.front()->robots.front(), *task)),
      agent_model(make_agent_model(
          options, clock,
          options.observed.pose || task->reads_scan() || std::ranges::find(task_fields, true) != task_fields.end())),
      measures_odometry(options.localization != Localization::truth &&
                        (agent_model.localizes || agent_model.scans || options.observed.velocity)),
      metric_names(task->metrics()),
      workers(options.threads),
      scratch(options.threads) {
  const std::size_t rows = options.worlds * options.robots;
  episodes.resize(options.worlds);
  ended.resize(options.worlds);
  metrics.resize(rows * metric_names.size());
  if (options.autoreset == Autoreset::same_step) final_metrics.resize(metrics.size());
  states.resize(rows);
  agents.resize(rows);
  actions.resize(rows);
  commands.resize(rows);
  done.resize(rows);
  rewards.resize(rows);
  terminated.resize(rows);
  truncated.resize(rows);
  true_poses.resize(3 * rows);
  scan_ages.resize(rows);
  observations = make_arrays(fields, rows);
  final_observations = make_arrays(fields, options.autoreset == Autoreset::same_step ? rows : 0);
  prepare_scratch();
}

void Batch::Impl::prepare_scratch() {
  const std::size_t rays = rays_of(*task, options.hardware);
  for (std::size_t part = 0; part < scratch.size(); ++part) {
    Scratch& own = scratch[part];
    own.moments.resize(options.robots);
    own.outcomes.resize(options.robots);
    own.beliefs.resize(options.robots);
    for (task::Belief& belief : own.beliefs) {
      if (!clock.scans) continue;
      belief.base_from_lidar = agent_model.profile.lidar->base_from_lidar;
      belief.range_max = agent_model.profile.lidar->range_max;
    }
    if (rays > 0) own.rays.assign(options.robots, std::vector<float>(rays));
    for (std::size_t robot = 0; robot < options.robots; ++robot) {
      own.looks.emplace_back([this, part, robot] { return look(scratch[part].world, robot, part); });
    }
    for (std::size_t robot = 0; robot < options.robots; ++robot) {
      own.moments[robot].look = &own.looks[robot];
      if (!own.rays.empty()) own.moments[robot].ranges = own.rays[robot];
    }
  }
}

void Batch::Impl::check_actions(std::span<const float> asked) const {
  env::check_actions(asked, options.worlds * options.robots);
  for (std::size_t world = 0; world < options.worlds; ++world) {
    const Episode& episode = episodes[world];
    if (!episode.begun) throw ContractError("step() before the first reset()");
    if (episode.over && options.autoreset == Autoreset::disabled) {
      throw ContractError(fmt::format("step(): the episode of environment {} is over; reset it first", world));
    }
  }
}

template <typename Chosen, typename Work>
void Batch::Impl::for_blocks(const Chosen& chosen, const Work& work) {
  workers.run(options.worlds, [&](std::size_t part, std::size_t begin, std::size_t end) {
    std::array<std::size_t, kBlock> block;
    std::size_t count = 0;
    for (std::size_t world = begin; world < end; ++world) {
      if (chosen(world)) block[count++] = world;
      if (count == kBlock || (world + 1 == end && count > 0)) {
        work(Worlds(block).first(count), part);
        count = 0;
      }
    }
  });
}

Batch::Batch(Options options) {
  const std::size_t worlds = options.worlds;
  try {
    impl_ = std::make_unique<Impl>(std::move(options));
  } catch (const std::bad_alloc&) {
    throw ConfigError(fmt::format("num_envs: there is no memory for {} environments", worlds));
  }
}
Batch::~Batch() = default;

const Options& Batch::options() const { return impl_->options; }

void Batch::reset(std::span<const Reset> resets, std::span<const bool> mask) {
  Impl& impl = *impl_;
  const ExclusiveUse use(impl.busy, "reset");
  const auto fits = [&](std::size_t size) { return size == 0 || size == impl.options.worlds; };
  if (!fits(resets.size()) || !fits(mask.size())) {
    throw ContractError(
        fmt::format("reset: one reset and one flag of the mask for each of {} environments, got {} and {}",
                    impl.options.worlds, resets.size(), mask.size()));
  }
  for (std::size_t world = 0; world < impl.options.worlds; ++world) {
    if (!mask.empty() && !mask[world]) continue;
    if (!impl.episodes[world].begun && (resets.empty() || !resets[world].seed)) {
      throw ContractError(fmt::format("reset: environment {} needs a seed for its first episode", world));
    }
    if (!resets.empty() && resets[world].scene && *resets[world].scene >= impl.options.scenes.size()) {
      throw ContractError(
          fmt::format("reset: there is no scene {}, only {}", *resets[world].scene, impl.options.scenes.size()));
    }
  }
  impl.for_blocks([&](std::size_t world) { return mask.empty() || mask[world]; },
                  [&](Impl::Worlds worlds, std::size_t part) {
                    impl.begin(worlds, resets);
                    for (const std::size_t world : worlds) {
                      impl.clear_outcomes(world);
                      impl.observe(world, impl.observations, part);
                      impl.measure(world, impl.metrics);
                    }
                  });
}

void Batch::step(std::span<const float> actions) {
  Impl& impl = *impl_;
  const ExclusiveUse use(impl.busy, "step");
  impl.check_actions(actions);
  impl.for_blocks([](std::size_t) { return true; },
                  [&](Impl::Worlds worlds, std::size_t part) { impl.step_block(worlds, actions, part); });
}

std::span<const Array> Batch::observations() const { return impl_->observations; }
std::span<const Array> Batch::final_observations() const { return impl_->final_observations; }
std::span<const double> Batch::rewards() const { return impl_->rewards; }
std::span<const std::uint8_t> Batch::terminated() const { return impl_->terminated; }
std::span<const std::uint8_t> Batch::truncated() const { return impl_->truncated; }
std::span<const std::uint8_t> Batch::ended() const { return impl_->ended; }
std::span<const std::uint8_t> Batch::done() const { return impl_->done; }
const std::vector<std::string>& Batch::metric_names() const { return impl_->metric_names; }
std::span<const double> Batch::metrics() const { return impl_->metrics; }
std::span<const double> Batch::final_metrics() const { return impl_->final_metrics; }
std::span<const double> Batch::true_poses() const { return impl_->true_poses; }
std::span<const double> Batch::scan_ages() const {
  std::ranges::transform(impl_->states, impl_->scan_ages.begin(),
                         [this](const sim::RobotState& state) { return impl_->scan_age(state); });
  return impl_->scan_ages;
}
std::string Batch::instruction_name() const { return impl_->task->instruction_name(); }

EpisodeInfo Batch::episode(std::size_t world) const {
  check_place(world, impl_->options.worlds);
  const ExclusiveUse use(impl_->busy, "episode");
  return impl_->episodes[world].info;
}

std::string Batch::instruction(std::size_t world) const {
  check_place(world, impl_->options.worlds);
  const ExclusiveUse use(impl_->busy, "instruction");
  if (!impl_->episodes[world].begun) throw ContractError("instruction() before the first reset()");
  return impl_->task->instruction(world);
}

models::Variation Batch::variation(std::size_t world, std::size_t robot) const {
  check_place(world, impl_->options.worlds, robot, impl_->options.robots);
  const ExclusiveUse use(impl_->busy, "variation");
  return impl_->states[impl_->row(world, robot)].variation;
}

TopView Batch::top_view(std::size_t world) const {
  check_place(world, impl_->options.worlds);
  const ExclusiveUse use(impl_->busy, "top_view");
  return impl_->top_view(world);
}

}  // namespace threewe::env
