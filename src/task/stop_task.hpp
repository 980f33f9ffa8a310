// STOP termination and reward that ObjectNav and VLN share: the robot says STOP where it believes it has arrived.
#pragma once

#include <algorithm>
#include <limits>
#include <span>

#include "threewe/core/time.hpp"

namespace threewe::task {

/// STOP is said by all three commands below this share of their scale ...
inline constexpr float kStopBelow = 0.05F;
/// ... for this long.
inline constexpr Duration kStopAfter = 500ms;
/// What success is worth, in metres of progress.
inline constexpr double kSuccessReward = 10.0;

/// How long the robot has been asked to stand still. Plain data.
struct StopState {
  Duration still{};
  friend bool operator==(const StopState&, const StopState&) = default;
};

/// The state after a control step of any length with a normalised action (vx, vy, omega), each in [-1, 1].
inline StopState advance(StopState state, std::span<const float, 3> action, Duration period) {
  const bool still = std::ranges::all_of(action, [](float a) { return -kStopBelow < a && a < kStopBelow; });
  state.still = still ? state.still + period : Duration{};
  return state;
}

/// Whether the robot has said STOP.
inline bool says_stop(const StopState& state) { return state.still >= kStopAfter; }

/// What changes during an episode. Plain data.
struct StopTaskState {
  StopState stop;
  double distance = 0.0;  ///< [m], the shortest path from the robot to where it should stop
  friend bool operator==(const StopTaskState&, const StopTaskState&) = default;
};

/// What a control step comes to.
struct StopTaskStep {
  double reward = 0.0;
  bool terminated = false;  ///< by STOP, right or wrong
  bool success = false;
  friend bool operator==(const StopTaskStep&, const StopTaskStep&) = default;
};

/// Advances an episode by one control step, after which the robot is `distance` [m] from where it should stop, and
/// `is_right()` tells whether it may stop where it is (asked on STOP alone). The reward is
///
///   r(t) = d(t-1) - d(t) + 10 [the robot says STOP and is right],
///
/// with d the length [m] of the shortest path that is left. It is potential-based: all that is earned on the way is the
/// distance between the first place and the last. Where no length is known, as in a gap just wide enough, d stays.
template <typename IsRight>
StopTaskStep advance(StopTaskState& state, std::span<const float, 3> action, Duration period, double distance,
                     IsRight&& is_right) {
  if (!(distance < std::numeric_limits<double>::infinity())) distance = state.distance;
  StopTaskStep step;
  step.reward = state.distance - distance;
  state.distance = distance;
  state.stop = advance(state.stop, action, period);
  step.terminated = says_stop(state.stop);
  step.success = step.terminated && is_right();
  if (step.success) step.reward += kSuccessReward;
  return step;
}

/// Success weighted by path length (Anderson et al. 2018, "On evaluation of embodied navigation agents"): 0 for a
/// failure, else the shortest length over the one driven, at most 1. Where the shortest length is 0, as from a start
/// that was asked for, no way is too long: 1 for a success. Lengths in [m].
inline double success_weighted_by_path_length(bool success, double shortest, double driven) {
  if (!success) return 0.0;
  return shortest > 0.0 ? shortest / std::max(shortest, driven) : 1.0;
}

}  // namespace threewe::task
