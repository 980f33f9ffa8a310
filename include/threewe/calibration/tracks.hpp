// How a robot moved when it was told something: on any backend, and in the embedded simulator.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "threewe/backend/world.hpp"
#include "threewe/calibration/manoeuvres.hpp"
#include "threewe/scene/scene.hpp"

namespace threewe::calibration {

/// Where velocities come from.
enum class Source : std::uint8_t {
  truth,   ///< a simulator tells how its body moves
  sensors  ///< wheel odometry, and the gyro for turns where there is one: slip of all wheels alike stays unseen
};
std::string_view to_string(Source source);

/// What one manoeuvre came to, at the end of each control period.
struct Track {
  std::vector<Velocity> velocities;  ///< in the body frame
  std::vector<Pose2D> poses;         ///< from where it began; truth alone, else empty
};

/// Drives the first robot of a world, which is connected, through all of them: each from its start where the world
/// can be reset, else from wherever the one before ended. Truth is used where the world has it.
std::vector<Track> drive(backend::World& world, std::span<const Manoeuvre> manoeuvres);

/// The embedded simulator without noise, as the same robot's twin.
class Twin {
 public:
  /// `like`: the truth where `source` says so, else what sensors would say.
  Twin(std::shared_ptr<const scene::Scene> scene, Source like);

  std::vector<Track> drive(const RobotProfile& profile, std::span<const Manoeuvre> manoeuvres) const;

 private:
  std::shared_ptr<const scene::Scene> scene_;
  Source like_;
};

/// How far apart two sets of tracks are.
struct Deviation {
  double linear = 0.0;         ///< of (vx, vy): root mean square of the difference over that of the reference
  double angular = 0.0;        ///< the same of omega
  double combined = 0.0;       ///< the same of both, weighed as kinetic energy weighs them
  double pose = 0.0;           ///< where they end, over the distance driven: mean
  double farthest_pose = 0.0;  ///< the worst
};
/// Poses count only where both have them.
Deviation compare(const RobotProfile& profile, std::span<const Track> tracks, std::span<const Track> reference);

}  // namespace threewe::calibration
