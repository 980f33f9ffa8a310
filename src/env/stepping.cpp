// How time goes by.
#include <algorithm>
#include <array>

#include "env/batch_impl.hpp"
#include "sim/step.hpp"

namespace threewe::env {
namespace {

constexpr std::uint64_t kStepsPerTick = kControlPeriod / sim::kStep;

}  // namespace

// Worlds whose episode is over begin the next one instead, or right after, as `Autoreset` has it.
void Batch::Impl::step_block(Worlds worlds, std::span<const float> asked, std::size_t part) {
  std::array<std::size_t, kBlock> list;
  std::size_t over = 0;  // from the list's end
  std::size_t going = 0;
  for (const std::size_t world : worlds) {
    (episodes[world].over ? list[kBlock - ++over] : list[going++]) = world;
  }
  const Worlds restarted = std::span(list).last(over);
  const Worlds stepped = std::span(list).first(going);
  if (!restarted.empty()) begin(restarted, {});
  for (const std::size_t world : restarted) clear_outcomes(world);
  step(stepped, asked, part);

  if (options.autoreset == Autoreset::same_step) {
    const auto alive = std::partition(list.begin(), list.begin() + static_cast<std::ptrdiff_t>(going),
                                      [&](std::size_t world) { return !episodes[world].over; });
    const Worlds ends(alive, list.begin() + static_cast<std::ptrdiff_t>(going));
    for (const std::size_t world : ends) {
      observe(world, final_observations, part);
      measure(world, final_metrics);
    }
    if (!ends.empty()) begin(ends, {});
  }
  for (const std::size_t world : worlds) {
    observe(world, observations, part);
    measure(world, metrics);
  }
}

void Batch::Impl::step(Worlds worlds, std::span<const float> asked, std::size_t part) {
  for (const std::size_t world : worlds) {
    for (std::size_t i = row(world); i < row(world + 1); ++i) {
      const auto share = [&](std::size_t axis) { return std::clamp(double{asked[3 * i + axis]}, -1.0, 1.0); };
      actions[i] = done[i] ? Velocity{} : Velocity{share(0), share(1), share(2)};
    }
  }
  advance(worlds, clock.period);
  for (const std::size_t world : worlds) end_step(world, part);
}

// Physics goes on for so many steps, a whole number of the robot's control periods, at whose beginnings the gate
// decides and at whose ends the sensors' readings arrive.
void Batch::Impl::advance(Worlds worlds, std::uint64_t steps) {
  const bool varies = !options.randomization.interval.empty();
  for (std::uint64_t tick = 0; tick < steps / kStepsPerTick; ++tick) {
    for (const std::size_t world : worlds) {
      if (varies) draw_anew(world);
      for (std::size_t i = row(world); i < row(world + 1); ++i) {
        const sim::RobotModel& robot = model_of(world).robots[i - row(world)];
        commands[i] = agents[i].act(agent_model, robot, states[i], actions[i], states[i].time());
      }
    }
    for (std::uint64_t i = 0; i < kStepsPerTick; i += clock.stride) step_physics(worlds);
    for (const std::size_t world : worlds) {
      for (std::size_t i = row(world); i < row(world + 1); ++i)
        agents[i].perceive(agent_model, model_of(world).robots[i - row(world)], states[i], states[i].time());
    }
  }
}

// What is randomised at intervals.
void Batch::Impl::draw_anew(std::size_t world) {
  Episode& episode = episodes[world];
  const Time now = states[row(world)].time();
  if (now < episode.next_draw) return;
  const auto& [seed, number, scene, steps] = episode.info;
  ++episode.draws;
  for (std::size_t robot = 0; robot < options.robots; ++robot) {
    const auto variation = models::draw_variation(options.randomization, seed, number, robot, episode.draws);
    sim::vary(model_of(world).robots[robot], variation, states[row(world, robot)]);
  }
  episode.next_draw = now + models::draw_interval(options.randomization, seed, number, episode.draws);
}

// As many steps as nothing happens in between.
void Batch::Impl::step_physics(Worlds worlds) {
  std::array<sim::World, kBlock> block;
  std::array<ScanUse, kBlock> uses;  // NOLINT: what is used is filled
  for (std::size_t i = 0; i < worlds.size(); ++i) {
    const std::size_t world = worlds[i];
    const ScanUse use = clock.use_of_scan(states[row(world)].steps);
    uses[i] = use;
    // what moves comes from afar
    const bool nearby = use == ScanUse::gate && options.robots == 1 && episodes[world].people.empty();
    const std::span<Pose2D> path = use == ScanUse::none ? std::span<Pose2D>() : agents[row(world)].path();
    block[i] = {&model_of(world),
                robots_of(world),
                std::span(commands).subspan(row(world), options.robots),
                episodes[world].people,
                {.lidar = use == ScanUse::observed || (use == ScanUse::gate && path.empty()),
                 .lidar_reach = nearby ? agent_model.gate_sight : sim::RayCaster::kEverything,
                 .imu = false,
                 .odometry = measures_odometry,
                 .ultrasonics = false},
                path};
  }
  sim::step(std::span(block).first(worlds.size()), static_cast<int>(clock.stride));

  for (std::size_t i = 0; i < worlds.size(); ++i) {
    const std::size_t world = worlds[i];
    const sim::Model& model = *block[i].model;
    if (clock.scans && sim::scan_ready(model.robots[0], states[row(world)])) {
      for (std::size_t robot = 0; robot < options.robots; ++robot) {
        const std::size_t at = row(world, robot);
        agents[at].end_turn(agent_model, model.robots[robot], states[at], uses[i]);
      }
    }
    if (options.observed.image || options.observed.depth) {
      episodes[world].pictures.note(model, robots_of(world), episodes[world].people);
    }
  }
}

}  // namespace threewe::env
