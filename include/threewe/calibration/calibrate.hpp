// What the embedded simulator's drive must be like so that it moves as another robot does.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "threewe/calibration/tracks.hpp"

namespace threewe::calibration {

/// One figure of a profile, as it was fitted.
struct Figure {
  std::string name;     ///< of its field below `body`
  double before = 0.0;  ///< in the profile, or what follows from it
  double value = 0.0;   ///< fitted, in the profile's unit
  double spread = 0.0;  ///< half of its 95 % interval
  bool told = false;    ///< whether the manoeuvres say more about it than was assumed beforehand
};

/// The outcome of a calibration.
struct Calibration {
  RobotProfile profile;         ///< the fitted one
  std::vector<Figure> figures;  ///< what was fitted
  Source source{};              ///< of the velocities
  double seconds = 0.0;         ///< of robot time driven
  Deviation before;             ///< of the manoeuvres, by the profile as it was
  Deviation after;              ///< and by the fitted one
};

/// Fits a profile's drive to tracks of manoeuvres: least squares of the body's velocity over all periods, by Levenberg
/// and Marquardt through the simulator itself, with derivatives by differences. What the tracks do not tell stays near
/// the profile's own figure. Intervals are robust against errors that belong together within a manoeuvre (Liang and
/// Zeger 1986).
Calibration fit(const RobotProfile& profile, const Twin& twin, std::span<const Manoeuvre> manoeuvres,
                std::span<const Track> tracks, Source source);

/// Drives the standard manoeuvres on a backend, and fits the profile to them. The backend's robot has no noise where it
/// is simulated. Throws ConfigError for an unknown backend or profile.
Calibration calibrate(std::string_view backend, const std::string& hardware);

/// The profile `hardware` as a file, with the figures of a calibration in place of its own.
std::string to_yaml(const std::string& hardware, const Calibration& calibration);

/// How far the embedded simulator with each of `profiles` is from a backend with `hardware`, on random sequences.
std::vector<Deviation> deviations(std::string_view backend, const std::string& hardware,
                                  std::span<const RobotProfile> profiles, std::uint64_t seed, std::size_t count,
                                  Pace pace);

/// How far a backend is from itself, on the same sequences, when the robot's wheels have turned a little before: what
/// no model of it can be nearer to than a share of 0.7. Velocities alone.
Deviation scatter(std::string_view backend, const std::string& hardware, std::uint64_t seed, std::size_t count,
                  Pace pace);

}  // namespace threewe::calibration
