// Recovery behaviours of a robot that makes no progress: a small state machine.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "nav/arc_escape.hpp"
#include "nav/params.hpp"
#include "nav/path_follower.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"
#include "threewe/nav/navigator.hpp"

namespace threewe::nav {

/// A robot that does not get on stands still until what it sees is fresh, backs off the way it came, leaves in arcs
/// where it cannot turn, turns to look, and plans anew; after a few times in one place it gives up and says why. A
/// robot that is lost only turns to look.
///
///   driving -> clearing -> backing_off -> arc_escape -> looking -> replanning -> driving
///      |                        |______________|______________________^
///      |-> given_up
class Recovery {
 public:
  using State = RecoveryState;

  /// A robot without a lidar looks each time, for it senses in a few directions only.
  Recovery(const RobotProfile& profile, const Params& params)
      : params_(params.recovery),
        creep_(params.creep),
        kinematics_(profile.kinematics()),
        hard_of_seeing_(!profile.lidar),
        arc_escape_(profile, params) {}

  /// Forgets everything: another motion begins.
  void reset();
  /// The way it came, while it drives.
  void remember(const Pose2D& odom_from_base);
  /// The robot does not get on in a place [m in `map`].
  void begin(Time now, const Pose2D& odom_from_base, Vec2 place);
  /// The robot stands where it is tight and plans lead nowhere: it leaves in arcs, and plans anew.
  void leave(Time now, const Pose2D& odom_from_base);
  /// The robot is lost: it turns once round itself.
  void look_round(Time now, const Pose2D& odom_from_base);
  /// One period of what has begun. `hits` [m]: what is near, in the base frame; `follower` sees the same.
  Velocity step(Time now, const Pose2D& odom_from_base, std::span<const Vec2> hits, const PathFollower& follower);
  /// Drives on: the plan has been made, or the robot is lost no more.
  void end() { state_ = State::driving; }

  State state() const { return state_; }
  bool active() const { return state_ != State::driving; }
  /// It moves where something is nearer than the margin.
  bool creep_mode() const { return state_ == State::arc_escape && arc_escape_.creep_mode(); }
  /// A differential base cannot turn here, so that it can only leave as it came, or in arcs.
  bool is_wedged(std::span<const Vec2> hits) const {
    return kinematics_ == Kinematics::differential && !can_turn(hits);
  }
  bool can_turn(std::span<const Vec2> hits) const { return arc_escape_.can_turn(hits); }
  /// How often it has begun in this place.
  int attempts() const { return attempts_; }
  /// There is another way now, so that it may try as often again.
  void forget_attempts() { attempts_ = 0; }
  /// Why it has given up.
  std::string_view reason() const;

 private:
  void enter(State state, Time now, const Pose2D& odom_from_base);
  Velocity back_off(Time now, const Pose2D& odom_from_base, std::span<const Vec2> hits, const PathFollower& follower);
  Velocity arc_escape(Time now, const Pose2D& odom_from_base, std::span<const Vec2> hits, const PathFollower& follower);
  void look_or_replan(Time now, const Pose2D& odom_from_base);
  Velocity along_trail(const Pose2D& odom_from_base, double speed);
  Velocity look(Time now, const Pose2D& odom_from_base, const PathFollower& follower);

  Params::Recovery params_;
  Params::Creep creep_;
  Kinematics kinematics_;
  bool hard_of_seeing_;
  ArcEscape arc_escape_;

  State state_ = State::driving;
  Time entered_{};             // the state ...
  Vec2 entered_at_;            // ... in `odom`
  double heading_ = 0.0;       // [rad] in the period before
  double turned_ = 0.0;        // [rad] since it began
  std::vector<double> looks_;  // [rad] still to turn to, counted from there
  Vec2 place_;
  int attempts_ = 0;
  bool had_room_ = false;      // it could back off, this time or before
  Velocity escape_;            // where there is most room, once the way it came is closed
  std::vector<Pose2D> trail_;  // odom_from_base, oldest first
};

}  // namespace threewe::nav
