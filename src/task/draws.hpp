// Random draws of one robot's episode, one after the other.
#pragma once

#include <cstddef>

#include "core/rng.hpp"
#include "scene/episodes.hpp"
#include "scene/scene_tables.hpp"
#include "threewe/task/task.hpp"

namespace threewe::task {

/// Counts the samples, so that no draw is used twice.
class Draws {
 public:
  Draws(const EpisodeKey& key, std::size_t robot)
      : key_{.seed = key.seed,
             .episode = key.episode,
             .robot = static_cast<std::uint16_t>(robot),
             .sensor = 2,  // apart from those of scene::sample_episode and of sample_free_pose
             .stream = Stream::sampler} {}

  /// In [0, 1).
  double uniform() { return threewe::uniform(key_, sample_++); }
  /// In [0, count).
  std::size_t index(std::size_t count) { return static_cast<std::size_t>(uniform() * static_cast<double>(count)); }
  Pose2D roomy_pose(const scene::SceneTables& tables) { return scene::sample_roomy_pose(tables, key_, sample_++); }

 private:
  RngKey key_;
  std::uint64_t sample_ = 0;
};

}  // namespace threewe::task
