// Tasks that come with the library: point-goal navigation, exploration, ObjectNav and VLN.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <string_view>

#include "threewe/task/task.hpp"

namespace threewe::task {

/// Which episodes are drawn, and what counts.
struct NavigationOptions {
  std::size_t goals = 64;  ///< in the pool of each scene
  double shortest = 2.0;   ///< [m], bounds of the shortest path from start to goal
  double longest = 15.0;   ///< [m]
  /// The share of episodes whose path is longer than 1.3 times the straight line, where the scene has any.
  double detours = 0.2;
  double success_distance = 0.5;  ///< [m] by the shortest path
  double contact_speed = 0.05;    ///< [m/s]: who meets an obstacle faster than this has failed
  bool goal_in_map = false;       ///< the `goal` field in the map's frame instead of the robot's
  bool stop = false;              ///< the robot has to say STOP, see `StopState`: an episode ends there, right or wrong
  bool contact_ends = true;       ///< without, contacts are counted and the episode goes on
};

/// `3we/Navigation-v1`. With d the length [m] of the shortest path from the robot to the goal,
///
///   reward = d(before) - d(now) - 0.01 + 10 [success] - 10 [contact],
///
/// the first part being potential-based with potential -d (Ng et al. 1999). An episode ends in success when d is at
/// most `success_distance`, in failure at a contact faster than `contact_speed`. Start and goal are drawn like those of
/// `scene::sample_episode`, the goal out of a pool. With several robots each has a goal of its own.
///
/// With `stop` (PointNav, Anderson et al. 2018) it succeeds only where the robot also says STOP there, and STOP
/// anywhere else ends it in failure. Without `contact_ends` no contact does, and each costs 0.1.
///
/// Field `goal` (2,): the goal [m] as the robot believes it to lie, x ahead and y to its left.
/// Metrics: `success`, `spl` (Anderson et al. 2018), `distance_to_goal` [m], `shortest_path` [m], `path_length` [m],
/// `collision_speed` [m/s]; of a robot that has arrived or failed those at that time. With `stop` also `stopped`,
/// without `contact_ends` also `contacts`: how often the body came to touch walls or furniture.
std::unique_ptr<Task> make_navigation(const TaskContext& context, const NavigationOptions& options = {});

/// What counts as explored.
struct ExplorationOptions {
  double enough = 0.95;  ///< the share of the place that ends an episode in success
};

/// `3we/Exploration-v1`. Covered is what noise-free rays from the lidar's true place have crossed within 8 m, as
/// `scene::CoverageMeter` has it: the share C of all reachable 5 cm cells, of area A [m^2] together. All robots of a
/// world cover for all of them, and all of them get
///
///   reward = 0.2 A (C(now) - C(before)) - 0.01 + 10 [C >= enough] - 0.1 [new contact],
///
/// the first part being potential-based; a contact counts when a robot meets an obstacle faster than it has before, and
/// faster than 0.05 m/s. An episode ends in success when enough is covered.
///
/// Field `coverage_map` (64, 64, 1), an image of one channel: what the robots of the world have seen so far, by their
/// own scans and beliefs: 0 unknown, 127 free, 255 occupied, in cells of 0.25 m. Rows go along the map's y axis,
/// columns along x; the robot is at the corner between cells (31, 31) and (32, 32). Metrics: `success`, `coverage`,
/// both of all robots together, `path_length` [m] and `collision_speed` [m/s] of the fastest contact.
std::unique_ptr<Task> make_exploration(const TaskContext& context, const ExplorationOptions& options = {});

/// The kinds of things that are looked for. A door is its leaf, which can be seen and gone up to; a doorway is not.
inline constexpr std::array<std::string_view, 10> kObjectGoals = {"chair", "desk",  "door",  "plant",        "monitor",
                                                                  "couch", "table", "shelf", "refrigerator", "bed"};

/// Which episodes are drawn.
struct ObjectNavOptions {
  /// Something of the kind is in sight, 1.5 to 5 m away; else nothing of it is in view.
  bool in_sight = false;
};

/// `3we/ObjectNav-v1`, for one robot in each world. See `advance` of `StopTaskState` for its reward.
///
/// Field `object_goal` (10,): 1 for the kind that is looked for. Words: `object_goal`, the kind.
/// Metrics: `success`, `spl`, `distance_to_goal` [m], `shortest_path` [m], `path_length` [m], `collision_speed` [m/s],
/// `stopped`.
std::unique_ptr<Task> make_object_nav(const TaskContext& context, const ObjectNavOptions& options = {});

/// `3we/VLN-v1`, for one robot in each world. See `advance` of `StopTaskState` for its reward.
///
/// Fields `instruction_tokens` (48,) and `instruction_embedding` (64,), see `language::Language`. Words: `instruction`.
/// Metrics: `success`, `spl`, `ndtw`, `distance_to_goal` [m], `shortest_path` [m], `path_length` [m],
/// `collision_speed` [m/s], `stopped`.
std::unique_ptr<Task> make_vln(const TaskContext& context);

}  // namespace threewe::task
