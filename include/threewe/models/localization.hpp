// Where a robot believes itself to be, without running its mind: wheel odometry between corrections that are off as
// those of our own SLAM are. `./dev verify slam --write-model` measures how far.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "threewe/core/pose.hpp"
#include "threewe/core/rng.hpp"
#include "threewe/core/time.hpp"

namespace threewe::models {

/// How far corrections are off. All that changes slowly is 0 at the start, where the map begins, and forgets itself
/// over the distance that the robot moves (Gauss-Markov processes); a robot that stands keeps its error. The default is
/// perfect.
struct LocalizationSpec {
  std::string name;  ///< for results, with its version: "slam_v2"
  std::string description;
  Duration period = 100ms;  ///< between corrections
  /// From the end of what was measured until the correction. For information: its effect is part of the errors.
  Duration delay = Duration::zero();

  /// The map that the robot draws is turned and stretched about its start, and its heading off by some more.
  struct Map {
    double turn = 0.0;     ///< [rad] standard deviation
    double stretch = 0.0;  ///< standard deviation, [m] off for each metre from the start
    double heading = 0.0;  ///< [rad] standard deviation of what adds to `turn`
    double length = 1.0;   ///< [m] after which correlations have fallen to 1/e
  } map;
  /// The neighbourhood may lie elsewhere in the map.
  struct Local {
    double position = 0.0;  ///< [m] standard deviation along each axis
    double length = 1.0;    ///< [m] as above
  } local;
  /// Each correction has its own.
  struct Scatter {
    double position = 0.0;  ///< [m] standard deviation along each axis
    double heading = 0.0;   ///< [rad] standard deviation
  } scatter;

  /// From what these figures come.
  struct Measurement {
    std::string commit;
    std::string hardware;
    std::string noise;
    std::vector<std::string> scenes;
    std::uint64_t seed = 0;
    int episodes = 0;
    double hours = 0.0;       ///< of driving
    double kilometres = 0.0;  ///< driven
  } measured;
};

/// Reads assets/localization/NAME.yaml, or the file itself where `name` ends in .yaml. Throws ConfigError.
LocalizationSpec load_localization(std::string_view name);
/// The names of all localisation models.
std::vector<std::string> localization_names();

/// What localisation carries from correction to correction. Plain data; as it is by default, an episode begins: at the
/// origin of `map`, which is where the robot starts.
struct LocalizationState {
  // the newest correction: where the robot believed to be, and what its odometer showed
  Pose2D map_from_base;
  Pose2D odom_from_base;

  Vec2 position;  ///< [m] where it truly was
  // what is slowly varying of the error
  double turn = 0.0;     ///< [rad]
  double stretch = 0.0;  ///< [m/m]
  double heading = 0.0;  ///< [rad] without `turn`
  Vec2 local;            ///< [m]
};
static_assert(std::is_trivially_copyable_v<LocalizationState>);
static_assert(sizeof(LocalizationState) == 13 * sizeof(double), "no padding");

/// Correction number `correction` of an episode, counted from 0, of a robot that truly stands at `truth` (in `map`,
/// whose origin is the start) while its odometer shows `odom_from_base`. A perfect one gives the truth to the bit.
void correct_localization(const LocalizationSpec& spec, const RngKey& key, std::uint64_t correction,
                          const Pose2D& truth, const Pose2D& odom_from_base, LocalizationState& state);

/// Where the robot believes to be, `map_from_base`, when its odometer shows `odom_from_base`.
Pose2D localized_pose(const LocalizationState& state, const Pose2D& odom_from_base);

}  // namespace threewe::models
