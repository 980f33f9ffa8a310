// Excitation sequences: commands whose response identifies a drive.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "threewe/core/pose.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe::calibration {

/// The scene in which simulated robots are calibrated, as `WorldOptions` takes it.
std::string test_arena();

/// How fast commands change.
enum class VelocityProfile : std::uint8_t {
  operating,  ///< within the operating limits, as whatever drives a robot makes them
  hardware,   ///< within what the profile says that the drive can do
  abrupt      ///< at once: wheels slip
};

/// One after the other, every control period another command (body frame), from a stand-still at `start`.
struct ExcitationSequence {
  std::string name;
  Pose2D start;  ///< in the scene's frame; on a robot that cannot be put there, wherever it stands
  std::vector<Velocity> commands;
};

/// Steps, ramps, circles, strafes, spins, and medleys of them, each there and back again; where the robot can be put
/// somewhere, it pushes against a wall of the hall too. Needs 2 m of free floor around the start.
std::vector<ExcitationSequence> standard_excitation(const RobotProfile& profile, bool with_wall);

/// Random sequences of 10 s: another velocity every half second, uniform up to 0.5 m/s ahead, 0.3 m/s sideways and
/// 1 rad/s, or what the operating limits allow. A pure function of the seed.
std::vector<ExcitationSequence> random_sequences(const RobotProfile& profile, std::uint64_t seed, std::size_t count,
                                                 VelocityProfile velocity_profile);

}  // namespace threewe::calibration
