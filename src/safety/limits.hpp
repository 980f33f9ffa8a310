// How fast a robot may go, and how fast that may change.
#pragma once

#include "threewe/core/pose.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe::safety {

/// Scales the vector (vx, vy), so that it keeps its direction, and clamps the turn rate.
Velocity within_limits(const Limits& limits, Velocity v);
/// The velocity on the way from `last` to `target` that one period allows. Passes its own result unchanged.
Velocity within_acceleration(const Limits& limits, const Velocity& last, const Velocity& target);

}  // namespace threewe::safety
