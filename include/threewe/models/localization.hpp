// Localization error model: wheel odometry between pose corrections that are off by Gauss-Markov drift and white noise,
// as those of our own SLAM are. `./dev verify slam --write-model` measures how far.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "threewe/core/time.hpp"

namespace threewe::models {

/// How far corrections are off. All that changes slowly is 0 at the start, where the map begins, and forgets itself
/// over the distance that the robot moves (Gauss-Markov processes); a robot that stands keeps its error. The default is
/// perfect.
struct LocalizationSpec {
  std::string name;         ///< for results, with its version: "slam_v2"
  std::string description;  ///< one line
  Duration period = 100ms;  ///< between corrections
  /// From the end of what was measured until the correction. For information: its effect is part of the errors.
  Duration delay = Duration::zero();

  /// The map that the robot draws is turned and stretched about its start, and its heading off by some more.
  struct Map {
    double turn = 0.0;     ///< [rad] standard deviation
    double stretch = 0.0;  ///< standard deviation, [m] off for each metre from the start
    double heading = 0.0;  ///< [rad] standard deviation of what adds to `turn`
    double length = 1.0;   ///< [m] after which correlations have fallen to 1/e
  } map;                   ///< errors of the map as a whole
  /// The neighbourhood may lie elsewhere in the map.
  struct Local {
    double position = 0.0;  ///< [m] standard deviation along each axis
    double length = 1.0;    ///< [m] as above
  } local;                  ///< errors of the robot's neighbourhood
  /// Each correction has its own.
  struct Noise {
    double position = 0.0;  ///< [m] standard deviation along each axis
    double heading = 0.0;   ///< [rad] standard deviation
  } noise;                  ///< noise of each correction

  /// From what these figures come.
  struct Measurement {
    std::string commit;               ///< that was measured
    std::string hardware;             ///< profile
    std::string noise;                ///< level of noise
    std::vector<std::string> scenes;  ///< in which the robot drove
    std::uint64_t seed = 0;           ///< of the drives
    int episodes = 0;                 ///< number of drives
    double hours = 0.0;               ///< of driving
    double kilometres = 0.0;          ///< driven
  } measured;                         ///< where the numbers come from
};

/// Reads assets/localization/NAME.yaml, or the file itself where `name` ends in .yaml. Throws ConfigError.
LocalizationSpec load_localization(std::string_view name);
/// The names of all localisation models.
std::vector<std::string> localization_names();

}  // namespace threewe::models
