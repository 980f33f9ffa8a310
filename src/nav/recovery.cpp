#include "nav/recovery.hpp"
#include "core/exact.hpp"

#include <algorithm>
#include <cmath>

namespace threewe::nav {
namespace {

constexpr std::size_t kTrailLength = 40;
constexpr double kBacktrackTurn = 0.1;  // [rad] between the poses of the way it came
constexpr double kNoRoom = 0.2;         // share of the way to back off, of which who cannot back off has no room

}  // namespace

void Recovery::reset() {
  end();
  attempts_ = 0, had_room_ = false;
  trail_.clear();
}

void Recovery::remember(const Pose2D& odom_from_base) {
  if (!trail_.empty()) {
    const Pose2D since = inverse(trail_.back()) * odom_from_base;
    if (norm(since.position()) < params_.backtrack_spacing && std::fabs(since.theta) < kBacktrackTurn) return;
  }
  if (trail_.size() == kTrailLength) trail_.erase(trail_.begin());
  trail_.push_back(odom_from_base);
}

void Recovery::begin(Time now, const Pose2D& odom_from_base, Vec2 place) {
  if (distance(place, place_) > params_.same_place) attempts_ = 0, had_room_ = false;
  place_ = place;
  heading_ = odom_from_base.theta, turned_ = 0.0;
  enter(++attempts_ > params_.attempts ? State::given_up : State::clearing, now, odom_from_base);
}

void Recovery::leave(Time now, const Pose2D& odom_from_base) {
  arc_escape_.begin(now);
  enter(State::arc_escape, now, odom_from_base);
}

void Recovery::look_round(Time now, const Pose2D& odom_from_base) {
  looks_ = {0.5 * exact::kPi, exact::kPi, 1.5 * exact::kPi, 2.0 * exact::kPi};
  heading_ = odom_from_base.theta, turned_ = 0.0;
  enter(State::looking, now, odom_from_base);
}

std::string_view Recovery::reason() const {
  return had_room_ ? "the way on stays blocked, whatever was tried" : "there is no room to move";
}

void Recovery::enter(State state, Time now, const Pose2D& odom_from_base) {
  state_ = state;
  entered_ = now;
  entered_at_ = odom_from_base.position();
  escape_ = {};
}

Velocity Recovery::step(Time now, const Pose2D& odom_from_base, std::span<const Vec2> hits,
                        const PathFollower& follower) {
  turned_ += wrap_angle(odom_from_base.theta - heading_);
  heading_ = odom_from_base.theta;
  switch (state_) {
    case State::clearing:
      if (now - entered_ >= params_.clearing) enter(State::backing_off, now, odom_from_base);
      return {};
    case State::backing_off: return back_off(now, odom_from_base, hits, follower);
    case State::arc_escape: return arc_escape(now, odom_from_base, hits, follower);
    case State::looking: return look(now, odom_from_base, follower);
    case State::driving:
    case State::replanning:
    case State::given_up: return {};
  }
  return {};
}

// The way it came; where that is closed too, out of a place too tight to turn in, or wherever there is most room.
Velocity Recovery::back_off(Time now, const Pose2D& odom_from_base, std::span<const Vec2> hits,
                            const PathFollower& follower) {
  const double moved = distance(odom_from_base.position(), entered_at_);
  const bool in_time = now - entered_ < params_.backing_off &&
                       moved < params_.backing_distance + params_.more_each_time * (attempts_ - 1);
  if (in_time && escape_ == Velocity{}) {
    const Velocity back = follower.safe(along_trail(odom_from_base, follower.escape_speed()));
    if (exact::hypot(back.vx, back.vy) >= 0.5 * creep_.speed) return back;
    if (!is_wedged(hits)) return escape_ = follower.most_room();
  }
  if (in_time && escape_ != Velocity{}) return follower.safe(escape_);
  had_room_ = had_room_ || moved >= kNoRoom * params_.backing_distance;
  if (is_wedged(hits)) {
    leave(now, odom_from_base);
  } else {
    look_or_replan(now, odom_from_base);
  }
  return {};
}

// In arcs, to where it can turn.
Velocity Recovery::arc_escape(Time now, const Pose2D& odom_from_base, std::span<const Vec2> hits,
                              const PathFollower& follower) {
  const Velocity velocity = arc_escape_.step(now, odom_from_base, hits, follower);
  had_room_ = had_room_ || distance(odom_from_base.position(), entered_at_) >= kNoRoom * params_.backing_distance;
  if (arc_escape_.over() || now - entered_ >= params_.arc_escape) look_or_replan(now, odom_from_base);
  return velocity;
}

void Recovery::look_or_replan(Time now, const Pose2D& odom_from_base) {
  looks_ = {turned_ + params_.look, turned_ - params_.look, turned_};
  enter(hard_of_seeing_ || attempts_ >= params_.look_from ? State::looking : State::replanning, now, odom_from_base);
}

Velocity Recovery::along_trail(const Pose2D& odom_from_base, double speed) {
  while (!trail_.empty() && distance(trail_.back().position(), odom_from_base.position()) < params_.backtrack_passed)
    trail_.pop_back();
  if (trail_.empty()) return {};

  const Pose2D to = inverse(odom_from_base) * trail_.back();
  const double away = norm(to.position());
  if (kinematics_ == Kinematics::holonomic) {
    return {speed * to.x / away, speed * to.y / away,
            std::clamp(to.theta, -creep_.free_turn_rate, creep_.free_turn_rate)};
  }
  // along the arc that leads there (Coulter 1992, pure pursuit), unless the robot has turned away since
  if (std::fabs(to.y) > 0.5 * std::fabs(to.x)) return {};
  const double forward = to.x >= 0.0 ? speed : -speed;
  return {forward, 0.0,
          std::clamp(forward * 2.0 * to.y / (away * away), -2.0 * creep_.free_turn_rate, 2.0 * creep_.free_turn_rate)};
}

// From one direction to the next, each as near as there is room to turn.
Velocity Recovery::look(Time now, const Pose2D& odom_from_base, const PathFollower& follower) {
  if (std::fabs(looks_.front() - turned_) <= params_.looked || now - entered_ >= params_.looking) {
    looks_.erase(looks_.begin());
    enter(looks_.empty() ? State::replanning : State::looking, now, odom_from_base);
  }
  return looks_.empty() ? Velocity{} : follower.turn(looks_.front() - turned_);
}

}  // namespace threewe::nav
