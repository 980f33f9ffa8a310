// Narrow-passage behaviour: lines up with, measures and creeps through a passage hardly wider than the robot.
#pragma once

#include <cstdint>
#include <span>

#include "nav/params.hpp"
#include "nav/path_follower.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe::nav {

/// A straight way between what the lidar hits, in `odom`.
struct Gap {
  Pose2D middle;             ///< x points through
  double half_length = 0.0;  ///< [m] of the narrow part
  double width = 0.0;        ///< [m] from side to side, at most twice `sight`
};

/// The widest straight way of the same length whose middle is within `offset` to either side of the guess's and whose
/// direction within `turn` of it.
Gap widest_way(std::span<const Vec2> hits, const Gap& guess, const Params::NarrowPassage& params);

/// Lines up before a gap, measures it, and creeps through its middle, straight; backs out and tries again where it gets
/// stuck.
///
///   lining_up -> entering -> through
///    ^   |          |
///    |   |          |-> closed: stuck too often
///    |   |          |-> backing_out
///    |   |-> closed: no room to turn
///    |   |-> too_narrow   |
///    |   |-> wide         |
///    |____________________|
class NarrowPassage {
 public:
  enum class State : std::uint8_t { idle, lining_up, entering, backing_out, through, closed, too_narrow, wide };

  NarrowPassage(const RobotProfile& profile, const Params& params);

  /// Where along the way through [m], counted from its middle, the robot lines up.
  double entry(double half_length) const { return -(half_length + ahead_ + params_.room_to_turn); }
  /// Whether a place is a passage for this robot: the hits leave it less than the gate's margin, and enough to pass.
  bool fits(const Gap& place, std::span<const Vec2> hits) const;
  void begin(Time now, const Pose2D& odom_from_base, const Pose2D& odom_from_middle, double half_length,
             std::span<const Vec2> hits);
  void end() { state_ = State::idle; }
  /// One period. `hits`: what is near, in `odom`, cleared of noise; `follower` sees the same.
  Velocity step(Time now, const Pose2D& odom_from_base, std::span<const Vec2> hits, PathFollower& follower);

  State state() const { return state_; }
  bool active() const { return state_ != State::idle; }
  /// Some of the robot is where it is narrow.
  bool creep_mode() const { return creep_mode_; }

 private:
  void measure(std::span<const Vec2> hits);
  void forget_extent();
  void measure_extent(std::span<const Vec2> hits);
  double measured_entry() const { return from_ - (facing_ == 0.0 ? ahead_ : behind_) - params_.room_to_turn; }
  void enter(State state, Time now);
  bool stands_still(Time now, double along);
  Velocity line_up(const Pose2D& in_gap, Time now, PathFollower& follower);
  double aside(const Pose2D& in_gap) const;
  Velocity drive(const Pose2D& in_gap, double speed, const PathFollower& follower) const;

  Params::NarrowPassage params_;
  Params::Creep creep_;
  double gain_;  // [1/s] of what a holonomic base is off
  Kinematics kinematics_;
  double ahead_;   // [m] of the base the body reaches ...
  double behind_;  // ... and this behind it
  double width_;   // [m] of the body ...
  double aside_;   // ... whose middle is so far to the left of the base
  double margin_;  // [m] that the gate keeps free elsewhere

  State state_ = State::idle;
  Gap gap_;
  double facing_ = 0.0;  // [rad] from the way through: 0, or pi
  double from_ = 0.0;    // [m] along the way, where its sides come nearer than the gate's margin ...
  double to_ = 0.0;      // ... as far as here
  bool creep_mode_ = false;
  int attempts_ = 0;
  Time entered_{};         // the state
  double furthest_ = 0.0;  // [m] along the way in this state ...
  Time furthest_at_{};     // ... and when
};

}  // namespace threewe::nav
