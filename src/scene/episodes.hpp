// Episode sampler of starts and goals: one for every test, environment and benchmark.
#pragma once

#include <cstdint>

#include "core/rng.hpp"
#include "scene/scene_tables.hpp"

namespace threewe::scene {

/// One task: from a pose to a place.
struct Episode {
  Pose2D start;
  Vec2 goal;
  double geodesic = 0.0;   ///< [m], from start to goal
  std::uint64_t seed = 0;  ///< for everything else that is drawn in this episode: people, noise
  friend bool operator==(const Episode&, const Episode&) = default;
};

/// Episodes have paths between these lengths [m], and this share of them with a path longer than `kDetour` times the
/// straight line.
inline constexpr double kShortestEpisode = 2.0;
inline constexpr double kLongestEpisode = 15.0;
inline constexpr double kDetour = 1.3;
inline constexpr double kDetourShare = 0.2;

/// Episode `index` of a seed. Start and goal are uniform over the cells where the footprint and 5 cm around it are free
/// in every heading, given the bounds above; the start's heading is uniform. A pure function of scene, footprint, seed
/// and index. In a scene too simple for detours there are none; throws ConfigError where there is no episode at all.
Episode sample_episode(const SceneTables& tables, std::uint64_t seed, std::uint32_t index);

/// A pose in the middle of a uniformly chosen roomy cell, heading anywhere, from the lanes of one sample.
Pose2D sample_roomy_pose(const SceneTables& tables, const RngKey& key, std::uint64_t sample);

}  // namespace threewe::scene
