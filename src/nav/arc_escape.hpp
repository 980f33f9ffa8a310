// Arc escape: lattice planner and controller that leave a place too tight to turn in, in short arcs.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "nav/params.hpp"
#include "nav/path_follower.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe::nav {

/// A short arc: a velocity of which only the ratio counts, and where it ends, in the frame in which it was planned.
struct ArcStep {
  Velocity direction;
  Pose2D end;
};

/// Lattice search in (x, y, heading) with the real outline: forward and backward arcs, turns on the spot and, for a
/// holonomic base, steps to all sides.
class ArcEscapePlanner {
 public:
  ArcEscapePlanner(const RobotProfile& profile, const Params& params);

  /// The quickest steps, in the base frame, to a pose in which the robot can turn on the spot with its whole margin
  /// free; where none is within `reach`, so far on. Hits [m] are in the base frame. What is nearer than a few
  /// millimetres already comes no nearer. Empty where there is no way.
  std::vector<ArcStep> plan(std::span<const Vec2> hits_in_base, double tolerance = 0.0) const;
  /// Nothing is so near that a turn on the spot would come closer to it than the margin, however the hits scatter.
  bool can_turn(std::span<const Vec2> hits_in_base) const { return room(hits_in_base, {}) >= turns_from_; }
  /// The same, and some more: a plan ends here.
  bool has_room(std::span<const Vec2> hits_in_base) const { return room(hits_in_base, {}) >= ends_at_; }
  /// Something is so near to the outline that a step could come nearer than the margin.
  bool is_tight(std::span<const Vec2> hits_in_base) const;
  double radius() const { return radius_; }

 private:
  /// One kind of step: how it moves, and the poses on its way.
  struct Primitive {
    Velocity direction;
    int gear = 0;       // 1 ahead, -1 back, 0 for turns and steps to the side
    double way = 0.0;   // [m]
    double turn = 0.0;  // [rad]
    std::vector<Pose2D> poses;
  };
  class Search;

  double room(std::span<const Vec2> hits, Vec2 place) const;
  void add_primitive(const Velocity& direction, double seconds);
  double seconds(const Primitive& step, double clearance) const;

  Params::Arcs params_;
  Params::Creep creep_;
  double thinning_;  // [m] hits nearer to each other than that are one
  double step_;      // [m] of a step; the lattice's cells are half of it
  Outline outline_;
  double radius_;      // [m] of the smallest disc around the base that holds the body
  double margin_;      // [m] that is kept free elsewhere
  double turns_from_;  // [m] to the nearest hit, from where on it can turn ...
  double ends_at_;     // ... and where plans end
  double least_room_;  // [m] nearer than this no place of the base is to a hit
  std::vector<Primitive> primitives_;
};

/// Drives a plan step by step, slowly wherever it is tight, and plans anew where a step cannot be driven.
class ArcEscape {
 public:
  ArcEscape(const RobotProfile& profile, const Params& params)
      : params_(params.arcs), creep_(params.creep), planner_(profile, params), quick_(profile.operating_limits) {}

  void begin(Time now);
  /// One period; hits [m] are in the base frame, and `follower` sees the same.
  Velocity step(Time now, const Pose2D& odom_from_base, std::span<const Vec2> hits_in_base,
                const PathFollower& follower);
  /// It has come to where it can turn, or there is no way.
  bool over() const { return over_; }
  /// Something is nearer than the margin.
  bool creep_mode() const { return creep_mode_; }
  bool can_turn(std::span<const Vec2> hits_in_base) const { return planner_.can_turn(hits_in_base); }

 private:
  bool plan(Time now, const Pose2D& odom_from_base, std::span<const Vec2> hits_in_base);
  bool stands_still(Time now, const Pose2D& odom_from_base);
  Velocity along(const ArcStep& step, const Pose2D& odom_from_base) const;

  Params::Arcs params_;
  Params::Creep creep_;
  ArcEscapePlanner planner_;
  Limits quick_;
  std::vector<ArcStep> steps_;  // in `odom`, still to drive
  int plans_ = 0;
  double tolerance_ = 0.0;  // [m] of the plan
  Time next_plan_{};        // when the next may be made
  bool over_ = true;
  bool creep_mode_ = false;
  Pose2D moved_at_;  // where ...
  Time moved_{};     // ... and when it last got on
};

}  // namespace threewe::nav
