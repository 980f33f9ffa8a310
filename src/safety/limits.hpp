// How fast a velocity may change.
#pragma once

#include "threewe/core/pose.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe::safety {

/// The velocity on the way from `last` to `target` that one period allows. Passes its own result unchanged.
Velocity within_acceleration(const Limits& limits, const Velocity& last, const Velocity& target);

}  // namespace threewe::safety
