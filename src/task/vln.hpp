// VLN, vision-and-language navigation: go where an instruction says, as in "Leave the kitchen through the door on your
// left and stop at the bookcase", and say STOP.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "language/vocabulary.hpp"
#include "scene/scene_tables.hpp"
#include "task/path_score.hpp"
#include "task/semantic_map.hpp"
#include "task/stop_task.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/task/task.hpp"

namespace threewe::task {

inline constexpr double kPathEndReach = 1.0;  ///< [m] by the shortest path: a right STOP is at most so far from the end
inline constexpr double kShortestVlnPath = 3.0;  ///< [m]
inline constexpr double kLongestVlnPath = 20.0;  ///< [m]

/// One episode.
struct VlnEpisode {
  Pose2D start;
  Vec2 end;
  std::size_t ending = 0;   ///< which of the scene's endings: what `distance` asks for
  double geodesic = 0.0;    ///< [m], the shortest path from start to end
  std::vector<Vec2> path;   ///< along it, 0.25 m apart, the start and the end included
  std::string instruction;  ///< English, at most 48 words
  std::uint64_t seed = 0;   ///< for everything else that is drawn in this episode: people, noise
  friend bool operator==(const VlnEpisode&, const VlnEpisode&) = default;
};

/// What changes during an episode. Plain data.
struct VlnState {
  StopTaskState stop;
  PathScore score;
  friend bool operator==(const VlnState&, const VlnState&) = default;
};

/// VLN in one scene for one robot: what is worked out once. Const and shared.
///
/// Instructions end at things, in the middle of rooms, or just inside of them. Of all that a scene offers, `endings`
/// are drawn, since each keeps a field of lengths. Every instruction has been followed, from its text and the map
/// alone, in every way in which it can be understood, and leads to the end of the path in each.
class Vln {
 public:
  /// Throws ConfigError for a scene without rooms, or in which there is nowhere to go.
  explicit Vln(std::shared_ptr<const scene::SceneTables> tables, int endings = 32);
  ~Vln();
  Vln(Vln&&) noexcept;
  Vln& operator=(Vln&&) noexcept;

  const scene::SceneTables& tables() const { return *tables_; }
  const SemanticMap& map() const { return map_; }
  const language::Language& language() const { return language_; }

  /// Episode `index` of a seed: a start, uniform over roomy cells and headings, and an ending, 3 to 20 m away, and
  /// words for the shortest path between them. A pure function of scene, robot, seed and index.
  VlnEpisode sample(std::uint64_t seed, std::uint32_t index) const;

  /// The shortest path [m] to an ending; infinity where there is none.
  double distance(std::size_t ending, Vec2 base) const;

  VlnState begin(const VlnEpisode& episode) const;
  /// Advances an episode by a control step that ended with the base at a point. STOP is right within 1 m of the path's
  /// end, by the shortest path. See `advance` for the reward.
  StopTaskStep step(const VlnEpisode& episode, VlnState& state, Vec2 base, std::span<const float, 3> action,
                    Duration period) const;

 private:
  struct Endings;

  std::shared_ptr<const scene::SceneTables> tables_;
  language::Language language_;
  SemanticMap map_;
  std::unique_ptr<const Endings> endings_;
};

}  // namespace threewe::task
