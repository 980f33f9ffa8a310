// How episodes begin, and what a step of them came to.
#include <algorithm>
#include <array>

#include "core/exact.hpp"
#include "core/rng.hpp"
#include "env/batch_impl.hpp"
#include "env/checks.hpp"
#include "env/episodes.hpp"
#include "models/camera.hpp"
#include "sim/camera.hpp"
#include "sim/step.hpp"

namespace threewe::env {
namespace {

// Each episode is in one of the scenes.
std::size_t draw_scene(std::uint64_t seed, std::uint32_t episode, std::size_t scenes) {
  const RngKey key{.seed = seed, .episode = episode, .sensor = 3, .stream = Stream::sampler};
  return static_cast<std::size_t>(uniform(key, 0) * static_cast<double>(scenes));
}

}  // namespace

EpisodeInfo next_episode(const EpisodeInfo* last, const Reset& asked, std::size_t scenes) {
  EpisodeInfo next;
  if (last != nullptr) next = {.seed = last->seed, .episode = last->episode + 1};
  if (asked.seed) next = {.seed = *asked.seed};
  if (asked.episode) next.episode = *asked.episode;
  next.scene = asked.scene ? *asked.scene : draw_scene(next.seed, next.episode, scenes);
  return next;
}

// All of them stand until each of their sensors has delivered once.
void Batch::Impl::begin(Worlds worlds, std::span<const Reset> resets) {
  for (const std::size_t world : worlds) begin_world(world, resets.empty() ? Reset{} : resets[world]);
  advance(worlds, clock.settle);
}

void Batch::Impl::begin_world(std::size_t world, const Reset& reset) {
  Episode& episode = episodes[world];
  const EpisodeInfo next = next_episode(episode.begun ? &episode.info : nullptr, reset, options.scenes.size());

  std::array<Pose2D, kMostRobots> starts;
  const auto poses = std::span(starts).first(options.robots);
  task->begin(world, {next.scene, next.seed, next.episode}, reset.request, poses);
  episode.info = next;
  episode.begun = true;
  episode.over = false;

  const sim::Model& model = model_of(world);
  const bool others_move = options.robots > 1 || !options.scenes[next.scene]->people.empty();
  for (std::size_t robot = 0; robot < options.robots; ++robot) {
    const std::size_t i = row(world, robot);
    const auto variation = models::draw_variation(options.randomization, next.seed, next.episode, robot);
    states[i] = sim::begin(model, robot, poses[robot], next.seed, next.episode, variation);
    agents[i].begin(agent_model, others_move);
    actions[i] = {};
    done[i] = 0;
  }
  episode.draws = 0;
  episode.next_draw = models::draw_interval(options.randomization, next.seed, next.episode, 0);
  episode.people = sim::begin_people(model, robots_of(world), next.seed, next.episode);
  episode.pictures.begin(options.robots);
}

// Rewards, ends and metrics of the step; what is observed now; and the next episode, where that is wanted at once.
void Batch::Impl::end_step(std::size_t world, std::size_t part) {
  Episode& episode = episodes[world];
  const std::size_t first = row(world);
  Scratch& own = scratch[part];
  own.world = world;
  for (std::size_t robot = 0; robot < options.robots; ++robot) {
    const sim::RobotState& state = states[first + robot];
    task::TaskState& now = own.moments[robot];
    now.pose = state.pose;
    now.action = actions[first + robot];
    now.distance_driven = state.distance_driven;
    now.max_collision_speed = state.max_collision_speed;
    own.outcomes[robot] = {};
    if (own.rays.empty()) continue;
    now.lidar = state.pose * options.hardware.lidar->base_from_lidar;
    cast_rays(world, robot, now.lidar, own.rays[robot]);
  }
  task->step(world, own.moments, own.outcomes);

  ++episode.info.steps;
  const bool time_is_up = episode.info.steps >= options.max_steps;
  bool over = true;
  for (std::size_t robot = 0; robot < options.robots; ++robot) {
    const std::size_t i = first + robot;
    const bool was_done = done[i] != 0;
    rewards[i] = was_done ? 0.0 : own.outcomes[robot].reward;
    terminated[i] = !was_done && own.outcomes[robot].terminated ? 1 : 0;
    truncated[i] = !was_done && !terminated[i] && time_is_up ? 1 : 0;
    done[i] = was_done || terminated[i] || truncated[i] ? 1 : 0;
    over = over && done[i];
  }
  episode.over = over;
  ended[world] = over ? 1 : 0;
}

// Noise-free rays from where the lidar really is, among what stands there and nothing that moves.
void Batch::Impl::cast_rays(std::size_t world, std::size_t robot, const Pose2D& lidar, std::span<float> ranges) const {
  const double increment = 2.0 * exact::kPi / static_cast<double>(ranges.size());
  model_of(world).robots[robot].caster->cast(lidar, 0.0, increment, ranges);
}

// What the robot's camera truly shows now.
std::span<const std::int16_t> Batch::Impl::look(std::size_t world, std::size_t robot, std::size_t part) {
  if (!options.hardware.camera) return {};
  const sim::RobotState& state = states[row(world, robot)];
  const CameraSpec camera = models::varied(*options.hardware.camera, state.variation);
  const sim::CapturePose capture = sim::capture_pose(robots_of(world), episodes[world].people, robot);
  SemanticImage& seen = scratch[part].seen;
  seen = sim::draw_truth(model_of(world), capture, camera.intrinsics(),
                         {state.pose * camera.base_from_camera, camera.mount_height}, false);
  return seen.ids;
}

// As a reset leaves them.
void Batch::Impl::clear_outcomes(std::size_t world) {
  ended[world] = 0;
  for (std::size_t i = row(world); i < row(world + 1); ++i) {
    rewards[i] = 0.0;
    terminated[i] = truncated[i] = 0;
  }
}

void Batch::Impl::measure(std::size_t world, std::vector<double>& to) const {
  const std::size_t size = options.robots * metric_names.size();
  task->measure(world, std::span(to).subspan(world * size, size));
}

}  // namespace threewe::env
