// Task interface of learning environments: episode starts, rewards, termination, observations and metrics.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"
#include "threewe/hardware/profile.hpp"
#include "threewe/scene/cell_grid.hpp"

namespace threewe::scene {
class SceneTables;
}

namespace threewe::task {

/// Scenes with their tables, shared by all worlds.
using Scenes = std::vector<std::shared_ptr<const scene::SceneTables>>;

/// What a task is set in.
struct TaskContext {
  Scenes scenes;            ///< each episode is in one of them
  std::size_t worlds = 1;   ///< in the batch
  std::size_t robots = 1;   ///< in each world
  RobotProfile robot{};     ///< all of them
  Duration period = 100ms;  ///< of a control step
};

/// The ids of what a robot's camera would truly show now, row by row, at the size of its profile's view: object i of
/// the scene has id 4 + i, as in SemanticImage.
using FrameIds = std::function<std::span<const std::int16_t>()>;

/// An array that a task adds to what a robot observes.
struct Field {
  /// Type of its elements.
  enum class Type : std::uint8_t { uint8, int32, float32 };
  std::string name;                ///< key in the observation
  Type type = Type::float32;       ///< of its elements
  std::vector<std::size_t> shape;  ///< of one robot's array
  double low = 0.0;                ///< every element lies in [low, high]
  double high = 0.0;               ///< see `low`
};

/// The truth about one robot at the end of a control step, in the scene's frame.
struct TaskState {
  Pose2D pose{};                     ///< true pose of the base
  Pose2D lidar{};                    ///< where its rays come from
  Velocity action{};                 ///< that was asked for: shares of the operating limits, -1 to 1
  double distance_driven = 0.0;      ///< [m] since the episode began
  double max_collision_speed = 0.0;  ///< [m/s] since the episode began
  const FrameIds* look = nullptr;    ///< asked for only where it matters: it takes a picture
  std::span<const float> ranges{};   ///< [m] of noise-free rays from there, see `Task::rays`
};

/// What a robot knows about itself.
struct Belief {
  Pose2D map_from_base{};         ///< its `map` has its origin where the first robot of its world started
  std::span<const float> scan{};  ///< [m] beams of the newest scan, counter-clockwise from the robot's back
  Pose2D base_from_lidar{};       ///< where its lidar is mounted
  double range_max = 0.0;         ///< [m] of the scan
};

/// What a step came to, for one robot.
struct Outcome {
  double reward = 0.0;      ///< of the step
  bool terminated = false;  ///< the episode is over for this robot, in success or failure
};

/// What a picture of a world shows of its task, in the scene's frame. Privileged.
struct DebugOverlay {
  std::vector<Vec2> goals{};  ///< of each robot; none where the task has no goals
  scene::CellSet ground{};    ///< 0 what needs not be seen, 1 what is still to be, 2 what has been; else no cells
};

/// Which episode.
struct EpisodeKey {
  std::size_t scene = 0;      ///< place in the list of scenes
  std::uint64_t seed = 0;     ///< that the episode is drawn from
  std::uint32_t episode = 0;  ///< number since that seed was given
};

/// What may be asked of an episode, instead of being drawn.
struct EpisodeRequest {
  std::optional<Pose2D> start{};          ///< in the scene's frame
  std::optional<Vec2> goal{};             ///< [m] in the scene's frame
  std::optional<std::string> category{};  ///< of the thing that is looked for
};

/// A task in many worlds, each with one or more robots. What is drawn is a pure function of an episode's key, and
/// rewards, ends and metrics are pure functions of the episode and of the task states since it began; the calls for
/// different worlds may come from different threads.
class Task {
 public:
  virtual ~Task() = default;

  /// Arrays that it adds to what a robot observes, and numbers that tell how an episode goes.
  virtual std::vector<Field> fields() const = 0;
  /// Names of the numbers that `measure` fills in.
  virtual std::vector<std::string> metrics() const = 0;
  /// How many noise-free rays it wants in each task state, evenly over the circle, the first along the
  /// lidar's heading.
  virtual std::size_t rays() const { return 0; }

  /// Begins an episode: fills in where the world's robots start. Throws ConfigError where a request can't be met.
  virtual void begin(std::size_t world, const EpisodeKey& key, const EpisodeRequest& request,
                     std::span<Pose2D> starts) = 0;
  /// The end of a control step, for all robots of a world.
  virtual void step(std::size_t world, std::span<const TaskState> robots, std::span<Outcome> outcomes) = 0;
  /// Whether `update` or `observe` reads the scan of a belief: where nothing else does, no scan is made, and it is
  /// empty.
  virtual bool reads_scan() const { return true; }
  /// What a robot believes at the end of a control step, or as an episode begins: called for all robots of a world
  /// before any of them observes.
  virtual void update(std::size_t /*world*/, const Belief& /*belief*/) {}
  /// Fills in one robot's fields, in order; each span holds one field of one robot, or nothing where it is not wanted.
  virtual void observe(std::size_t world, std::size_t robot, const Belief& belief,
                       std::span<const std::span<std::byte>> fields) = 0;
  /// What a world's episode is about in words, and what these words are called: an instruction, a category. Empty where
  /// there are none.
  virtual std::string instruction(std::size_t /*world*/) const { return {}; }
  /// What `instruction` is called, such as "object_goal".
  virtual std::string instruction_name() const { return {}; }
  /// Fills in the metrics of a world as they are now: one row for each of its robots.
  virtual void measure(std::size_t world, std::span<double> metrics) const = 0;
  /// What a picture of a world shows of the task.
  virtual DebugOverlay debug_overlay(std::size_t /*world*/) const { return {}; }
};

}  // namespace threewe::task
