// Stochastic error model of a localization: Gauss-Markov drift and white noise of each correction.
#pragma once

#include <cstdint>
#include <type_traits>

#include "core/exact.hpp"
#include "core/rng.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/models/localization.hpp"

namespace threewe::models {

/// What localisation carries from correction to correction. Plain data; as it is by default, an episode begins: at the
/// origin of `map`, which is where the robot starts.
struct LocalizationState {
  // the newest correction: where the robot believed to be, and what its odometer showed
  Pose2D map_from_base;
  Pose2D odom_from_base;
  exact::SinCos map_from_odom{0.0, 1.0};  ///< of the angle between the two

  Vec2 position;  ///< [m] where it truly was
  // what is slowly varying of the error
  double turn = 0.0;     ///< [rad]
  double stretch = 0.0;  ///< [m/m]
  double heading = 0.0;  ///< [rad] without `turn`
  Vec2 local;            ///< [m]
};
static_assert(std::is_trivially_copyable_v<LocalizationState>);
static_assert(sizeof(LocalizationState) == 15 * sizeof(double), "no padding");

/// Correction number `correction` of an episode, counted from 0, of a robot that truly stands at `truth` (in `map`,
/// whose origin is the start) while its odometer shows `odom_from_base`. A perfect one gives the truth to the bit.
void correct_localization(const LocalizationSpec& spec, const RngKey& key, std::uint64_t correction,
                          const Pose2D& truth, const Pose2D& odom_from_base, LocalizationState& state);

/// Where the robot believes to be, `map_from_base`, when its odometer shows `odom_from_base`.
Pose2D localized_pose(const LocalizationState& state, const Pose2D& odom_from_base);

}  // namespace threewe::models
