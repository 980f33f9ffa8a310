// How fast a robot may go: the one place where a velocity is scaled down to it.
#pragma once

#include "threewe/core/pose.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe {

/// `v` no faster than `limits.linear` and `limits.angular`. The vector (vx, vy) keeps its direction, however long it
/// is. Passes its own result unchanged.
Velocity within_limits(const Limits& limits, Velocity v);

}  // namespace threewe
