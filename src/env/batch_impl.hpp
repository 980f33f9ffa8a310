// What a batch keeps, and what it does with it. Its parts are in files of their own: episodes.cpp begins and ends
// episodes, stepping.cpp lets time go by, observing.cpp looks.
#pragma once

#include <atomic>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "env/agent.hpp"
#include "env/clock.hpp"
#include "env/pictures.hpp"
#include "env/places.hpp"
#include "env/workers.hpp"
#include "sim/people.hpp"
#include "threewe/env/batch.hpp"

namespace threewe::env {

inline constexpr std::size_t kBlock = 32;  // worlds that are stepped together, so that they stay in the cache

// One world's episode.
struct Episode {
  EpisodeInfo info;
  bool begun = false;
  bool over = false;
  std::vector<sim::PersonState> people;
  Pictures pictures;
  std::uint64_t draws = 0;  // of the randomisation since the episode began
  Time next_draw{};
};

// What a thread needs for the world in hand; lists hold one thing for each of its robots.
struct Scratch {
  std::size_t world = 0;
  std::vector<task::FrameIds> looks;
  std::vector<task::TaskState> moments;
  std::vector<task::Outcome> outcomes;
  std::vector<task::Belief> beliefs;
  std::vector<std::vector<float>> rays;  // noise-free
  SemanticImage seen;
  sim::DrawScratch drawing;
};

struct Batch::Impl {
  explicit Impl(Options wanted);

  // a whole step, and a whole reset, of some worlds
  using Worlds = std::span<const std::size_t>;
  void begin(Worlds worlds, std::span<const Reset> resets);
  void step(Worlds worlds, std::span<const float> actions, std::size_t part);

  // their parts
  void step_block(Worlds worlds, std::span<const float> actions, std::size_t part);
  void clear_outcomes(std::size_t world);
  void measure(std::size_t world, std::vector<double>& to) const;
  void begin_world(std::size_t world, const Reset& reset);
  void draw_anew(std::size_t world);
  void advance(Worlds worlds, std::uint64_t steps);
  void step_physics(Worlds worlds);
  void prepare_scratch();
  void end_step(std::size_t world, std::size_t part);
  void cast_rays(std::size_t world, std::size_t robot, const Pose2D& lidar, std::span<float> ranges) const;
  std::span<const std::int16_t> look(std::size_t world, std::size_t robot, std::size_t part);
  void observe(std::size_t world, std::vector<Array>& arrays, std::size_t part);
  TopView top_view(std::size_t world) const;
  void update_belief(std::size_t world, std::size_t robot, task::Belief& belief) const;
  double scan_age(const sim::RobotState& state) const;
  std::vector<Vec2> hits_around(std::size_t world, std::size_t robot) const;

  void check_actions(std::span<const float> asked) const;
  /// Calls `work(worlds, part)` for blocks of the worlds that are chosen, on all threads.
  template <typename Chosen, typename Work>
  void for_blocks(const Chosen& chosen, const Work& work);

  std::size_t row(std::size_t world, std::size_t robot = 0) const { return world * options.robots + robot; }
  std::span<sim::RobotState> robots_of(std::size_t world) {
    return std::span(states).subspan(row(world), options.robots);
  }
  const sim::Model& model_of(std::size_t world) const { return *places.models[episodes[world].info.scene]; }

  // never changes
  Options options;
  Places places;
  std::unique_ptr<task::Task> task;
  std::vector<task::Field> fields;  // that are observed
  std::vector<bool> task_fields;    // which of the task's fields are wanted
  Clock clock;
  AgentModel agent_model;
  bool measures_odometry;  // something reads what the wheels say
  std::vector<std::string> metric_names;

  // of each world
  std::vector<Episode> episodes;
  std::vector<std::uint8_t> ended;
  std::vector<double> metrics;
  std::vector<double> final_metrics;

  // of each robot
  std::vector<sim::RobotState> states;
  std::vector<Agent> agents;
  std::vector<Velocity> actions;  // in force
  std::vector<Velocity> commands;
  std::vector<std::uint8_t> done;  // its part of the episode is over
  // what the last call came to
  std::vector<double> rewards;
  std::vector<std::uint8_t> terminated;
  std::vector<std::uint8_t> truncated;
  std::vector<double> true_poses;
  std::vector<double> scan_ages;  // when they were last asked for
  std::vector<Array> observations;
  std::vector<Array> final_observations;

  std::atomic<bool> busy{};  // with a call
  Workers workers;
  std::vector<Scratch> scratch;  // of each thread
};

}  // namespace threewe::env
