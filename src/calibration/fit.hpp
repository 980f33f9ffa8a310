// Least-squares fit of a drive model to recorded tracks, and the deviations that are left.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/excitation.hpp"
#include "calibration/tracks.hpp"
#include "threewe/calibration/calibrate.hpp"

namespace threewe::calibration {

/// Fits a profile's drive to tracks of manoeuvres: least squares of the body's velocity over all periods, by Levenberg
/// and Marquardt through the simulator itself, with derivatives by differences. What the tracks do not tell stays near
/// the profile's own figure. Intervals are robust against errors that belong together within a manoeuvre (Liang and
/// Zeger 1986).
Calibration fit(const RobotProfile& profile, const Twin& twin, std::span<const ExcitationSequence> sequences,
                std::span<const Track> tracks, Source source);

/// How far the embedded simulator with each of `profiles` is from a backend with `hardware`, on random sequences.
std::vector<Deviation> deviations(std::string_view backend, const std::string& hardware,
                                  std::span<const RobotProfile> profiles, std::uint64_t seed, std::size_t count,
                                  VelocityProfile velocity_profile);

/// How far a backend is from itself, on the same sequences, when the robot's wheels have turned a little before: what
/// no model of it can be nearer to than a share of 0.7. Velocities alone.
Deviation repeatability(std::string_view backend, const std::string& hardware, std::uint64_t seed, std::size_t count,
                        VelocityProfile velocity_profile);

}  // namespace threewe::calibration
