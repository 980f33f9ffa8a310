// Learning environment around one robot of any backend, with the autonomy stack and the gate that a `Robot` has.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "threewe/env/batch.hpp"
#include "threewe/env/options.hpp"
#include "threewe/robot/world.hpp"

namespace threewe::env {

/// A robot at a task. It has what a `Batch` of one has, and goes about it as a program that calls `execute_action`
/// does.
///
/// The backend must be able to reset, and to tell where its robot truly is. `pose`, `velocity` and goals in the robot's
/// frame are what the robot believes. With the truth for a localizer (`autonomy_with("truth")`) and the embedded
/// simulator, observations, rewards, ends and metrics are those of a `Batch` with `Localization::truth`, to the bit.
class RobotEnv {
 public:
  /// Of `options`, scenes, hardware and randomisation are as the backend has them. `robot` says which backend, profile,
  /// noise, randomisation and autonomy; each of the `scenes`, names or files, gets a world of its own. Throws
  /// ConfigError naming what the backend lacks, or an option that robots have no use for.
  RobotEnv(Options options, const World::Options& robot, const std::vector<std::string>& scenes);
  ~RobotEnv();
  RobotEnv(const RobotEnv&) = delete;
  RobotEnv& operator=(const RobotEnv&) = delete;

  /// As given, with what was left out filled in.
  const Options& options() const;
  /// Connects the robot where it is not, puts it where the episode starts, and waits for its sensors. Throws
  /// ConnectionError where it fails, as `step` does.
  void reset(const Reset& reset);
  /// One control step, see `Batch::step`. Throws ContractError, too, where the episode is over.
  void step(std::span<const float> action);

  // As of a `Batch`, with one row.
  /// What the robot observes now.
  std::span<const Array> observations() const;
  std::span<const double> rewards() const;           ///< (1,) of the last step.
  std::span<const std::uint8_t> terminated() const;  ///< (1,) success or failure.
  std::span<const std::uint8_t> truncated() const;   ///< (1,) `max_steps` are over.
  /// Names of the metrics.
  const std::vector<std::string>& metric_names() const;
  std::span<const double> metrics() const;     ///< (1, names): the metrics now.
  std::span<const double> true_poses() const;  ///< (1, 3): true pose [m, m, rad] in the scene's frame. Privileged.
  std::span<const double> scan_ages() const;   ///< (1,) [s] since the newest scan was complete.
  /// Which episode the world is in.
  EpisodeInfo episode(std::size_t world = 0) const;
  /// What the episode is about, as `Batch::instruction`.
  std::string instruction(std::size_t world = 0) const;
  /// What `instruction` is called; empty where the task has none.
  std::string instruction_name() const;
  /// How the backend has the robot differ from its profile, as the episode began: simulators draw it alike.
  models::Variation variation(std::size_t world = 0, std::size_t robot = 0) const;
  /// The world that the robot is in when it is in a scene, for recordings. Throws ContractError where there is none.
  threewe::World& world(std::size_t scene = 0);
  /// The world from above. Throws ContractError before the first reset.
  TopView top_view(std::size_t world = 0) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace threewe::env
