// Path follower: MPPI plans for robots with a lidar, pure pursuit for those without, and the turns, straight lines and
// escapes of both.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "map/costmap.hpp"
#include "nav/mppi.hpp"
#include "nav/params.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe::nav {

/// A robot's outline as half planes, for quick tests of many points.
class Outline {
 public:
  explicit Outline(const Footprint& footprint);
  /// A lower bound on the signed distance [m] from a point in the base frame to the outline, exact next to an edge.
  double clearance(Vec2 point_in_base) const;

 private:
  struct Edge {
    Vec2 normal;
    double offset = 0.0;
  };
  std::vector<Edge> edges_;
};

/// How far a constant velocity leads before something is hit.
struct Sweep {
  double seconds = 0.0;  ///< [s] until contact, at most the horizon
  bool free = false;     ///< nothing within the horizon
};

/// Follows paths.
class PathFollower {
 public:
  PathFollower(const RobotProfile& profile, const Params& params);

  /// What is near: points in the base frame [m]. The robot's margin and `spare` [m] are kept free around the outline;
  /// what is nearer already comes no nearer.
  void update(std::span<const Vec2> obstacles_in_base, double spare);

  /// The velocity for following `path`, in `odom` from the robot on, to a stop at its end. For robots with a lidar.
  Velocity follow(std::span<const Vec2> path, const MppiObservation& seen);
  /// The plan that `follow` followed at `now`, see Mppi::plan.
  std::optional<SampledPlan> plan(Time now) const { return mppi_ ? mppi_->plan(now) : std::nullopt; }
  /// The same for the last bit of the way, which may be tight, and without a lidar: what echoes tell is too coarse to
  /// be rolled out against. It leads along where nothing is in the way, at the pace that leaves room to stop. `path`
  /// and `pose` are in `map`. A holonomic base faces so far `aside` [rad] to the left of where it drives.
  Velocity pursue(std::span<const Vec2> path, const map::Costmap& costmap, const Pose2D& pose, double aside);
  /// The velocity for turning by `angle` [rad] on the spot.
  Velocity turn(double angle) const;
  /// The velocity for driving along the base's x axis by `distance` [m], off the line by `offset` [m] (positive: the
  /// line is to the left) and by `heading` [rad] (positive: the line points to the left).
  Velocity straight(double distance, double offset, double heading);
  /// [m/s] at which to drive out of a tight place.
  double escape_speed() const;
  /// A slow motion into the direction with most room, away from what is near.
  Velocity most_room() const;
  /// A turn on the spot was begun that is blocked both ways.
  bool trapped() const { return turned_back_ >= 2; }
  /// The turn that was begun is given up.
  void forget_turn() { turning_ = turned_back_ = 0; }
  /// `wanted`, slowed down so that the robot can stop before it touches anything; zero when it cannot move at all.
  Velocity safe(const Velocity& wanted) const;

 private:
  Velocity towards(Vec2 target_in_base, double speed_limit, double aside);
  bool faces_first(double bearing);
  Velocity face(double bearing);
  Sweep sweep(const Velocity& velocity, double horizon, double inside = 0.0) const;
  double allowed_fraction(const Velocity& velocity, double inside = 0.0) const;  // of the margin [m]
  double speed_before(double distance) const;
  double turn_rate_before(double angle) const;

  Params::Follower params_;
  Params::Creep creep_;
  Limits limits_;
  Kinematics kinematics_;
  Outline outline_;
  std::optional<Mppi> mppi_;  // of a robot with a lidar
  double radius_;             // [m] of a disc around the body
  double full_speed_;         // [m/s]
  double margin_;             // [m] that the gate keeps ...
  double inside_;             // [m] ... and so much of it plans may use: ranges may be off, and scans are noisy
  double spare_ = 0.0;        // [m]
  double reach_ = 0.0;        // [m] points farther away do not matter
  std::vector<Vec2> near_;
  std::vector<double> least_;  // [m] how near each point may come
  int turned_back_ = 0;        // how often this turn met an obstacle and changed its direction
  int turning_ = 0;            // the direction of a turn on the spot that has begun: 1, -1, 0 for none
};

}  // namespace threewe::nav
