#include "nav/narrow_passage.hpp"
#include "core/exact.hpp"
#include "safety/params.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace threewe::nav {
namespace {

constexpr int kTurns = 24;          // tried to either side
constexpr double kPerTurn = 0.001;  // share of the sight, of width that a turn away from the guess must bring

}  // namespace

Gap widest_way(std::span<const Vec2> hits, const Gap& guess, const Params::NarrowPassage& params) {
  Gap best = guess;
  double most = -std::numeric_limits<double>::infinity();
  std::vector<double> sides;
  for (int turn = -kTurns; turn <= kTurns; ++turn) {
    Pose2D middle = guess.middle;
    middle.theta = wrap_angle(middle.theta + params.turn * turn / kTurns);
    const auto [s, c] = exact::sincos(middle.theta);
    sides = {-params.sight, params.sight};
    for (const Vec2 hit : hits) {
      const Vec2 d = hit - middle.position();
      const double across = c * d.y - s * d.x;
      if (std::fabs(c * d.x + s * d.y) <= guess.half_length && std::fabs(across) < params.sight)
        sides.push_back(across);
    }
    std::sort(sides.begin(), sides.end());
    for (std::size_t i = 1; i < sides.size(); ++i) {
      const double off = 0.5 * (sides[i - 1] + sides[i]);
      const double width = sides[i] - sides[i - 1];
      const double worth = width - kPerTurn * params.sight * std::abs(turn);
      if (std::fabs(off) > params.offset || worth <= most) continue;
      most = worth;
      best.middle = {middle.x - s * off, middle.y + c * off, middle.theta};
      best.width = width;
    }
  }
  return best;
}

NarrowPassage::NarrowPassage(const RobotProfile& profile, const Params& params)
    : params_(params.narrow_passage),
      creep_(params.creep),
      gain_(params.follower.position_gain),
      kinematics_(profile.kinematics()) {
  const auto& corners = profile.body.footprint.corners();
  const auto [rear, front] = std::ranges::minmax(corners, {}, &Vec2::x);
  const auto [right, left] = std::ranges::minmax(corners, {}, &Vec2::y);
  ahead_ = front.x;
  behind_ = -rear.x;
  width_ = left.y - right.y;
  aside_ = 0.5 * (left.y + right.y);
  margin_ = safety::margin_of(profile);
}

bool NarrowPassage::fits(const Gap& place, std::span<const Vec2> hits) const {
  const double spare = widest_way(hits, place, params_).width - width_;
  return spare > params_.least_spare && spare < 2.0 * (margin_ + params_.in_line);
}

void NarrowPassage::begin(Time now, const Pose2D& odom_from_base, const Pose2D& odom_from_middle, double half_length,
                          std::span<const Vec2> hits) {
  gap_ = {odom_from_middle, half_length, 0.0};
  attempts_ = 0;
  // who drives in all directions need not turn round
  const double turned = wrap_angle(odom_from_base.theta - odom_from_middle.theta);
  facing_ = kinematics_ == Kinematics::holonomic && std::fabs(turned) > 0.5 * exact::kPi ? exact::kPi : 0.0;
  const Pose2D in_gap = inverse(odom_from_middle) * odom_from_base;
  const bool is_inside = in_gap.x > -half_length && std::fabs(wrap_angle(facing_ - in_gap.theta)) < params_.askew;
  forget_extent();
  measure_extent(hits);
  const bool is_beyond_entry = in_gap.x > measured_entry() + 0.5 * params_.room_to_turn;
  enter(is_inside ? State::entering : is_beyond_entry ? State::backing_out : State::lining_up, now);
}

void NarrowPassage::enter(State state, Time now) {
  state_ = state;
  entered_ = furthest_at_ = now;
  furthest_ = -std::numeric_limits<double>::infinity();
}

Velocity NarrowPassage::step(Time now, const Pose2D& odom_from_base, std::span<const Vec2> hits,
                             PathFollower& follower) {
  measure(hits);
  const Pose2D in_gap = inverse(gap_.middle) * odom_from_base;
  const double nose = in_gap.x + (facing_ == 0.0 ? ahead_ : behind_);
  const double tail = in_gap.x - (facing_ == 0.0 ? behind_ : ahead_);
  const bool is_beside = nose > from_ && tail < to_;
  creep_mode_ = is_beside && state_ != State::lining_up;  // there it may turn as fast as anywhere
  const double speed = creep_mode_ ? creep_.speed : creep_.free_speed;
  switch (state_) {
    case State::lining_up: return line_up(in_gap, now, follower);
    case State::entering:
      if (const bool stuck = stands_still(now, in_gap.x); tail >= to_ || (stuck && nose > gap_.half_length)) {
        enter(State::through, now);  // what stops it beyond the far end is not this passage
      } else if (stuck) {
        enter(++attempts_ < params_.attempts ? State::backing_out : State::closed, now);
      }
      return drive(in_gap, speed, follower);
    case State::backing_out:
      if (in_gap.x <= measured_entry() || stands_still(now, -in_gap.x)) enter(State::lining_up, now);
      return drive(in_gap, -speed, follower);
    case State::idle:
    case State::through:
    case State::closed:
    case State::too_narrow:
    case State::wide: return {};
  }
  return {};
}

void NarrowPassage::measure(std::span<const Vec2> hits) {
  const Gap seen = widest_way(hits, gap_, params_);
  const double gain = gap_.width > 0.0 ? params_.gain : 1.0;
  const Vec2 shift = gain * (seen.middle.position() - gap_.middle.position());
  gap_.middle = {gap_.middle.x + shift.x, gap_.middle.y + shift.y,
                 wrap_angle(gap_.middle.theta + gain * wrap_angle(seen.middle.theta - gap_.middle.theta))};
  if (gap_.width == 0.0) forget_extent();  // it was that of a guess
  gap_.width += gain * (seen.width - gap_.width);
  measure_extent(hits);
}

void NarrowPassage::forget_extent() {
  from_ = std::numeric_limits<double>::infinity();
  to_ = -from_;
}

// Where the robot needs less than the gate's margin beside it, as far as was ever seen: the lidar may be blind inside.
void NarrowPassage::measure_extent(std::span<const Vec2> hits) {
  const Pose2D gap_from_odom = inverse(gap_.middle);
  const double first = -(gap_.half_length + params_.room_before);
  for (const Vec2 hit : hits) {
    const Vec2 p = gap_from_odom * hit;
    if (std::fabs(p.y) > 0.5 * width_ + margin_ + params_.in_line || p.x < first || p.x > gap_.half_length) continue;
    from_ = std::max(std::min(from_, p.x - margin_), first);
    to_ = std::min(std::max(to_, p.x + margin_), gap_.half_length);
  }
  if (from_ <= to_) return;
  from_ = first;
  to_ = gap_.half_length;
}

bool NarrowPassage::stands_still(Time now, double along) {
  if (along > furthest_ + creep_.progress) furthest_ = along, furthest_at_ = now;
  return now - furthest_at_ > params_.patience;
}

// Onto the line through the gap, as far as the base can, and along it; what is too narrow is seen from there.
Velocity NarrowPassage::line_up(const Pose2D& in_gap, Time now, PathFollower& follower) {
  const bool measured = now - entered_ >= params_.measuring;
  if (measured && gap_.width < width_ + params_.least_spare) return enter(State::too_narrow, now), Velocity{};
  if (measured && gap_.width > width_ + params_.most_spare) return enter(State::wide, now), Velocity{};
  const double turn = wrap_angle(facing_ - in_gap.theta);
  const bool in_line = kinematics_ == Kinematics::differential || std::fabs(aside(in_gap)) <= params_.in_line;
  const bool in_vain = now - entered_ > params_.patience;
  if (measured && std::fabs(turn) <= params_.aligned && (in_line || in_vain)) enter(State::entering, now);
  if (in_vain && std::fabs(turn) > params_.askew) return enter(State::closed, now), Velocity{};
  if (in_vain) enter(State::entering, now);
  return std::fabs(turn) > params_.aligned ? follower.turn(turn) : drive(in_gap, 0.0, follower);
}

// [m] by which the middle of the body is to go to the left of the way through.
double NarrowPassage::aside(const Pose2D& in_gap) const { return (facing_ == 0.0 ? -aside_ : aside_) - in_gap.y; }

// Along the line, and back onto it.
Velocity NarrowPassage::drive(const Pose2D& in_gap, double speed, const PathFollower& follower) const {
  const double off = aside(in_gap);
  const double turn = wrap_angle(facing_ - in_gap.theta);
  if (kinematics_ == Kinematics::holonomic) {
    const double most = std::max(std::fabs(speed), creep_.speed);
    const Vec2 along = rotate({speed, std::clamp(gain_ * off, -most, most)}, -in_gap.theta);
    return follower.safe({along.x, along.y, std::clamp(gain_ * turn, -creep_.free_turn_rate, creep_.free_turn_rate)});
  }
  // critically damped along the way, forwards or backwards
  const double direction = speed < 0.0 ? -1.0 : 1.0;
  const double curvature = (direction * off / params_.convergence + 2.0 * turn) / params_.convergence;
  return follower.safe(
      {speed, 0.0, std::clamp(std::fabs(speed) * curvature, -creep_.free_turn_rate, creep_.free_turn_rate)});
}

}  // namespace threewe::nav
