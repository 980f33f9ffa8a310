// Drive-model calibration: fits the embedded simulator's drive to the motion of another robot or simulator.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "threewe/hardware/profile.hpp"

namespace threewe::calibration {

/// Where velocities come from.
enum class Source : std::uint8_t {
  truth,   ///< a simulator tells how its body moves
  sensors  ///< wheel odometry, and the gyro for turns where there is one: slip of all wheels alike stays unseen
};
/// Its name.
std::string_view to_string(Source source);

/// How far apart two sets of tracks are.
struct Deviation {
  double linear = 0.0;         ///< of (vx, vy): root mean square of the difference over that of the reference
  double angular = 0.0;        ///< the same of omega
  double combined = 0.0;       ///< the same of both, weighed as kinetic energy weighs them
  double pose = 0.0;           ///< where they end, over the distance driven: mean
  double farthest_pose = 0.0;  ///< the worst
};
/// One figure of a profile, as it was fitted.
struct Figure {
  std::string name;           ///< of its field below `body`
  double before = 0.0;        ///< in the profile, or what follows from it
  double value = 0.0;         ///< fitted, in the profile's unit
  double spread = 0.0;        ///< half of its 95 % interval
  bool identifiable = false;  ///< whether the sequences say more about it than was assumed beforehand
};

/// The outcome of a calibration.
struct Calibration {
  RobotProfile profile;         ///< the fitted one
  std::vector<Figure> figures;  ///< what was fitted
  Source source{};              ///< of the velocities
  double seconds = 0.0;         ///< of robot time driven
  Deviation before;             ///< of the sequences, by the profile as it was
  Deviation after;              ///< and by the fitted one
};

/// Drives the standard sequences on a backend, and fits the profile to them. The backend's robot has no noise where it
/// is simulated. Throws ConfigError for an unknown backend or profile.
Calibration calibrate(std::string_view backend, const std::string& hardware);

/// The profile `hardware` as a file, with the figures of a calibration in place of its own.
std::string to_yaml(const std::string& hardware, const Calibration& calibration);

}  // namespace threewe::calibration
