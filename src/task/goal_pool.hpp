// Goals of one scene for point-goal navigation, with the way to each.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "scene/scene_tables.hpp"
#include "task/distance_field.hpp"
#include "threewe/core/pose.hpp"

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

}  // namespace threewe::task
