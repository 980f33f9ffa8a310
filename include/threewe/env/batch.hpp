// Batched learning environments: the same simulator, gate and tasks as everywhere else, without the autonomy stack.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "threewe/env/options.hpp"
#include "threewe/task/task.hpp"

namespace threewe::env {

/// One observation of all robots: robot r of world w is row `w * robots + r`.
struct Array {
  task::Field field;            ///< name, type and shape of a row
  std::vector<std::byte> data;  ///< (rows, shape of the field), row-major
  std::size_t row_bytes = 0;    ///< bytes of one row
  /// The bytes of row `i`.
  std::span<std::byte> row(std::size_t i) { return std::span(data).subspan(i * row_bytes, row_bytes); }
};

/// How one world is reset.
struct Reset {
  std::optional<std::uint64_t> seed{};     ///< begins with episode 0; without, the world's next episode follows
  std::optional<std::uint32_t> episode{};  ///< this one instead
  std::optional<std::size_t> scene{};      ///< instead of the one that the seed draws
  task::EpisodeRequest request{};          ///< start, goal and category, where they are not to be drawn
};

/// A world's episode, and how it goes.
struct EpisodeInfo {
  std::uint64_t seed = 0;     ///< that the episode was drawn from
  std::uint32_t episode = 0;  ///< its number since that seed was given
  std::size_t scene = 0;      ///< place in `Options::scenes`
  int steps = 0;              ///< taken
};

/// A world from above, in the scene's frame: for pictures. Privileged.
struct TopView {
  std::vector<Pose2D> robots;  ///< where each robot truly is
  /// [m] what each robot's newest scan hit, from where it truly was; where nothing reads scans, what stands around it.
  std::vector<std::vector<Vec2>> hits;
  std::vector<scene::Circle> people;  ///< what people fill on the floor
  task::DebugOverlay task;            ///< goals and ground of the task
};

/// Worlds with one or more robots each, every one an environment of its own. A world's episode is a pure function of
/// its seed, the episode's number and the actions, whatever else is in the batch and on however many threads.
///
/// An episode begins as a `Robot`'s does: the robot stands until each of its sensors has delivered once. Actions are
/// held for one control period; the gate looks at them every 20 ms.
///
/// One thread at a time uses a batch: a call during another one's throws ContractError and changes nothing.
class Batch {
 public:
  /// Makes tables of all scenes, which takes some 0.1 s each. Throws ConfigError where options don't fit together,
  /// or more is asked for than the system has.
  explicit Batch(Options options);
  ~Batch();
  Batch(const Batch&) = delete;
  Batch& operator=(const Batch&) = delete;

  /// As given, with what was left out filled in.
  const Options& options() const;
  /// Robots in all worlds: the first length of every array.
  std::size_t rows() const { return options().worlds * options().robots; }

  /// Begins an episode in every world, or in those of `mask` (one for each world, true = reset).
  void reset(std::span<const Reset> resets, std::span<const bool> mask = {});
  /// One control step. `actions`, shape (rows, 3), are shares of the operating limits: forward, left,
  /// counter-clockwise; beyond -1 to 1 they count as that. Throws ContractError, and changes nothing, where one is not
  /// finite, or where a world's episode is over and `Autoreset::disabled`.
  void step(std::span<const float> actions);

  /// What every robot observes now.
  std::span<const Array> observations() const;
  /// With `Autoreset::same_step`: what those whose episode ended in the last step observed at its end.
  std::span<const Array> final_observations() const;
  std::span<const double> rewards() const;           ///< of each robot
  std::span<const std::uint8_t> terminated() const;  ///< of each robot: success or failure
  std::span<const std::uint8_t> truncated() const;   ///< of each robot: `max_steps` are over
  /// Worlds whose episode ended in the last step.
  std::span<const std::uint8_t> ended() const;
  /// Of each robot: its part of the episode is over. What it is commanded counts for nothing until the next one.
  std::span<const std::uint8_t> done() const;
  /// Names of the metrics, and their values: shape (rows, names). With `Autoreset::same_step` those of episodes that
  /// have just begun, and `final_metrics` those at the end of the ones before.
  const std::vector<std::string>& metric_names() const;
  std::span<const double> metrics() const;        ///< (rows, names): the metrics now.
  std::span<const double> final_metrics() const;  ///< (rows, names): the metrics at the end of the episodes before.
  /// (rows, 3): true pose in the scene's frame. Privileged.
  std::span<const double> true_poses() const;
  /// (rows,) [s] since the newest scan was complete; valid until they are asked for again.
  std::span<const double> scan_ages() const;

  // Of one world. They throw ContractError where there is no such world, or no such robot in it.
  /// Which episode a world is in.
  EpisodeInfo episode(std::size_t world) const;
  /// What a world's episode is about, see `task::Task`; `instruction_name` says what these words are called. Throws
  /// ContractError before the first reset.
  std::string instruction(std::size_t world) const;
  /// What `instruction` is called, such as "object_goal"; empty where the task has none.
  std::string instruction_name() const;
  /// How a robot differs from its profile now.
  models::Variation variation(std::size_t world, std::size_t robot = 0) const;
  /// Throws ContractError before the first reset.
  TopView top_view(std::size_t world) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace threewe::env
