// Synthetic recorded logs of robots as they were around the year 2000: a forward-looking scanner, wheels that slip, no
// gyro, and the truth beside it. `threewe slam synth` writes them; mappers are compared with them.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "threewe/core/pose.hpp"
#include "threewe/core/samples.hpp"
#include "threewe/scene/scene.hpp"

namespace threewe::sim {

/// Where a tour leads.
struct LogSpec {
  std::string name;
  std::string description;
  scene::Scene scene;
  std::vector<Vec2> stops;  ///< one after the other, in the scene's frame; it begins at the scene's first start
};

/// Reads assets/logs/NAME.yaml, or the file itself where `name` ends in .yaml. Throws ConfigError with file:line.
LogSpec load_log_spec(std::string_view name);
/// The names of all surveys.
std::vector<std::string> log_names();

/// What was recorded at one moment.
struct RecordedScan {
  Time stamp{};
  Pose2D scene_from_base;  ///< the truth
  Pose2D odom_from_base;   ///< what the wheels say
  LaserScan scan;
};

/// Where the lidar of a survey's robot is.
Pose2D log_lidar();
/// Drives the tour: a scan every half metre, or third of a radian. A pure function of its arguments. Throws ConfigError
/// where a stop cannot be reached.
std::vector<RecordedScan> drive(const LogSpec& log, std::uint64_t seed);

}  // namespace threewe::sim
