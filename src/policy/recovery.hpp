// Recovery of a robot that a policy drives against what its picture does not show.
#pragma once

#include <optional>
#include <span>

#include "threewe/core/footprint.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/samples.hpp"
#include "threewe/core/time.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe::policy {

/// A policy that sees one picture wants to go on where a corner of the robot has come too near to a door frame beside
/// its camera, and will want so for ever. When the gate has let it stand for a while, the robot moves a little away
/// from what is nearest, farther each time in a row, and the policy goes on from there.
class Recovery {
 public:
  /// Of a robot that has had no need of it.
  explicit Recovery(const RobotProfile& profile);

  /// What to ask of the gate in a control tick: what the policy wants, or to move away. `stopped`: in the tick before,
  /// the gate let nothing of what was asked for through, since something is in the way. `scan`: the newest one, in the
  /// lidar's frame; null without a lidar.
  Velocity next(Time now, const Velocity& wanted, bool stopped, const LaserScan* scan);

  /// How often it has moved away.
  int count() const { return count_; }

 private:
  Velocity away(const Velocity& wanted, const LaserScan* scan) const;

  Footprint footprint_;
  Pose2D base_from_lidar_;
  bool sideways_;  // the base can move so
  double speed_;   // [m/s]
  std::optional<Time> stopped_since_;
  Velocity moving_;     // away ...
  Time until_{};        // ... until then
  double lasts_ = 0.0;  // [s]
  int count_ = 0;
};

/// The direction, of length 1, away from those of the points [m, in the base frame] that are nearest to a footprint;
/// zero without points, and between some that are equally near.
Vec2 away_from_nearest(const Footprint& footprint, std::span<const Vec2> points);

}  // namespace threewe::policy
