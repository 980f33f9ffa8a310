// Point-goal navigation: reach a place without touching anything.
#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "threewe/scene/episodes.hpp"
#include "threewe/task/distance_field.hpp"
#include "threewe/task/task.hpp"

namespace threewe::task {

/// Goals of one scene, uniform over the cells where a robot has 5 cm to spare, shared by all worlds. The way to a goal
/// from everywhere is found when it is first asked for.
class GoalPool {
 public:
  /// `goals` of them, drawn with `seed`.
  GoalPool(std::shared_ptr<const scene::SceneTables> tables, std::size_t goals, std::uint64_t seed);

  /// The way to a goal of the pool. Any number of threads may ask.
  std::shared_ptr<const DistanceField> field(std::size_t goal) const;
  /// The way to any place, which need not be in the pool.
  std::shared_ptr<const DistanceField> field_to(Vec2 target) const;

 private:
  struct Goal {
    Vec2 target;
    std::once_flag found;
    std::shared_ptr<const DistanceField> field;
  };
  std::shared_ptr<const scene::SceneTables> tables_;
  std::vector<std::unique_ptr<Goal>> goals_;
};

struct NavigationOptions {
  std::size_t goals = 64;  ///< in the pool of each scene
  double shortest = 2.0;   ///< [m], bounds of the shortest path from start to goal
  double longest = 15.0;   ///< [m]
  /// The share of episodes whose path is longer than 1.3 times the straight line, where the scene has any.
  double detours = scene::kDetourShare;
  double success_distance = 0.5;  ///< [m] by the shortest path
  double contact_speed = 0.05;    ///< [m/s]: who meets an obstacle faster than this has failed
  bool goal_in_map = false;       ///< the `goal` field in the map's frame instead of the robot's
};

/// `3we/Navigation-v1`. With d the length [m] of the shortest path from the robot to the goal,
///
///   reward = d(before) - d(now) - 0.01 + 10 [success] - 10 [contact],
///
/// the first part being potential-based with potential -d (Ng et al. 1999). An episode ends in success when d is at
/// most `success_distance`, in failure at a contact faster than `contact_speed`. Start and goal are drawn like those of
/// `scene::sample_episode`, the goal out of a pool. With several robots each has a goal of its own.
///
/// Field `goal` (2,): the goal [m] as the robot believes it to lie, x ahead and y to its left.
/// Metrics: `success`, `spl` (Anderson et al. 2018), `distance_to_goal` [m], `shortest_path` [m], `path_length` [m],
/// `collision_speed` [m/s]; of a robot that has arrived or failed those of that moment.
std::unique_ptr<Task> make_navigation(const Setting& setting, const NavigationOptions& options = {});

}  // namespace threewe::task
