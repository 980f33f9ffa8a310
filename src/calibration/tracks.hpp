// Recorded response of a robot to excitation sequences, on any backend and in the embedded simulator.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "calibration/excitation.hpp"
#include "threewe/backend/world.hpp"
#include "threewe/calibration/calibrate.hpp"
#include "threewe/scene/scene.hpp"

namespace threewe::calibration {

/// What one manoeuvre came to, at the end of each control period.
struct Track {
  std::vector<Velocity> velocities;  ///< in the body frame
  std::vector<Pose2D> poses;         ///< from where it began; truth alone, else empty
};

/// Drives the first robot of a world, which is connected, through all of them: each from its start where the world
/// can be reset, else from wherever the one before ended. Truth is used where the world has it.
std::vector<Track> drive(backend::World& world, std::span<const ExcitationSequence> sequences);

/// The embedded simulator without noise, as the same robot's twin.
class Twin {
 public:
  /// `like`: the truth where `source` says so, else what sensors would say.
  Twin(std::shared_ptr<const scene::Scene> scene, Source like);

  std::vector<Track> drive(const RobotProfile& profile, std::span<const ExcitationSequence> sequences) const;

 private:
  std::shared_ptr<const scene::Scene> scene_;
  Source like_;
};

/// Poses count only where both have them.
Deviation compare(const RobotProfile& profile, std::span<const Track> tracks, std::span<const Track> reference);

}  // namespace threewe::calibration
