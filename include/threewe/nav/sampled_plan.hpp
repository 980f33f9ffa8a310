// What path integral control weighs, for whoever wants to look on.
#pragma once

#include <vector>

#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"

namespace threewe::nav {

/// A plan, and the samples of which it is the weighted mean. Poses in `odom`, at the ends of the steps; velocities in
/// the body frame, as they are asked for: the poses are where these lead within the limits of the base.
struct SampledPlan {
  Time made{};                         ///< it begins a little later, when its first command takes effect
  double step = 0.0;                   ///< [s]
  std::vector<Pose2D> poses{};         ///< (steps,) where the plan leads
  std::vector<Velocity> velocities{};  ///< (steps,) what it asks for
  std::vector<Pose2D> trajectories{};  ///< (samples, steps) where each sample leads
  std::vector<Velocity> controls{};    ///< (samples, steps) what each asks for
  std::vector<double> weights{};       ///< (samples,) how much each counts; 1 in all
};

}  // namespace threewe::nav
