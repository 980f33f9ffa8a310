// ObjectNav: find something of a kind, such as a plant, go up to it so that the camera shows it, and say STOP.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "scene/scene_tables.hpp"
#include "scene/surfaces.hpp"
#include "task/stop_task.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/hardware/profile.hpp"
#include "threewe/scene/solid.hpp"
#include "threewe/task/task.hpp"
#include "threewe/task/tasks.hpp"

namespace threewe::task {

/// Where a kind stands in `kObjectGoals`. Throws ConfigError naming the nearest right one.
std::size_t object_goal(std::string_view category);
/// 1 where the kind stands, 0 elsewhere: the observation `object_goal`.
std::array<float, kObjectGoals.size()> one_hot(std::size_t goal);

/// A robot that says STOP is right when something of the goal's kind ...
inline constexpr double kGoalReach = 1.0;  ///< [m] or less from the base centre, at the nearest point of its footprint
inline constexpr int kGoalPixels = 200;    ///< shows this many pixels or more in the camera's current frame ...
inline constexpr double kGoalShare = 0.1;  ///< and this share of those it would have if nothing stood in front.
inline constexpr double kGoalDistance = 3.0;  ///< [m] from a start to everything of that kind, at least
/// [m] from a start by the shortest path to all places within reach of the kind, at least.
inline constexpr double kShortestSearch = 1.0;

/// Something is in sight where the camera shows it as success asks for, at most so far away.
inline constexpr double kSightFarthest = 5.0;  ///< [m] from the base centre to the nearest point of its footprint
inline constexpr double kSightNearest = 1.5;   ///< [m] from the start of an episode in sight to everything of the kind

inline constexpr std::int16_t kFirstObjectId{scene::kSurfaceNames.size()};

/// One episode.
struct ObjectNavEpisode {
  Pose2D start;
  std::size_t goal = 0;    ///< in `kObjectGoals`
  double geodesic = 0.0;   ///< [m], the shortest path from the start to a place of success
  std::uint64_t seed = 0;  ///< for everything else that is drawn in this episode: people, noise
  friend bool operator==(const ObjectNavEpisode&, const ObjectNavEpisode&) = default;
};

/// ObjectNav in one scene for one robot: what is worked out once. Const and shared.
///
/// Where a robot can succeed is known beforehand: on a lattice of 15 cm, the places within reach of something of the
/// kind from which, turned the right way, the camera sees enough of it among all that stands around. A monitor that no
/// robot of this height can see from 1 m away is no goal, and the path to a goal ends where success is possible.
class ObjectNav {
 public:
  /// Throws HardwareError for a robot without a camera, ConfigError for a scene in which nothing can be looked for.
  ObjectNav(std::shared_ptr<const scene::SceneTables> tables, const RobotProfile& robot);
  ~ObjectNav();
  ObjectNav(ObjectNav&&) noexcept;
  ObjectNav& operator=(ObjectNav&&) noexcept;

  const scene::SceneTables& tables() const { return *tables_; }
  /// The kinds that can be looked for in this scene, as they stand in `kObjectGoals`.
  const std::vector<std::size_t>& goals() const { return offered_; }

  /// Episode `index` of a seed: a kind of `goals()`, each as likely, or the one that is named; a start that is uniform
  /// over the roomy cells 3 m or more, by the shortest path, from the nearest reachable point of everything of that
  /// kind and 1 m or more from every place within reach of it, so that there is a way to drive; heading so that nothing
  /// of it is in view (200 pixels would be; what hides behind low furniture counts as seen). A pure function of scene,
  /// robot, seed and index. Throws ConfigError for a kind that is not in `goals()`.
  ObjectNavEpisode sample(std::uint64_t seed, std::uint32_t index, std::string_view category = {}) const;
  /// The same with something of the kind in sight and nothing of it nearer than 1.5 m, the start uniform over the roomy
  /// cells and all headings. Throws ConfigError where no such start was found, for any kind or for the one that is
  /// named.
  ObjectNavEpisode sample_in_sight(std::uint64_t seed, std::uint32_t index, std::string_view category = {}) const;
  /// The kinds of `goals()` that are in sight.
  std::vector<std::size_t> in_sight(const Pose2D& base) const;

  /// The shortest path [m] to a place of success; infinity where there is none.
  double distance(std::size_t goal, Vec2 base) const;
  /// The things of a kind, indices into `Scene::objects`, for which a robot at a pose may say STOP. Looks only if
  /// something of the kind is near enough.
  std::vector<std::size_t> found(std::size_t goal, const Pose2D& base, const FrameIds& look) const;
  /// Whether there is one.
  bool is_success(std::size_t goal, const Pose2D& base, const FrameIds& look) const {
    return !found(goal, base, look).empty();
  }

  StopTaskState begin(const ObjectNavEpisode& episode) const { return {.stop = {}, .distance = episode.geodesic}; }
  /// Advances an episode by a control step that ended with the base at a pose. See `advance` for the reward.
  StopTaskStep step(const ObjectNavEpisode& episode, StopTaskState& state, const Pose2D& base,
                    std::span<const float, 3> action, Duration period, const FrameIds& look) const;

 private:
  struct Goal;

  const Goal& goal_of(std::size_t goal) const;
  bool in_sight(const Goal& goal, const Pose2D& base) const;

  std::shared_ptr<const scene::SceneTables> tables_;
  CameraSpec camera_;
  std::array<std::unique_ptr<const Goal>, kObjectGoals.size()> goals_;
  std::vector<std::size_t> offered_;
  std::vector<scene::Solid> solids_;  // all of the scene's
};

}  // namespace threewe::task
