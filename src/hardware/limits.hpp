// Velocity and acceleration limits: the one place where a velocity is cut down to them.
#pragma once

#include "threewe/core/kinematics.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe {

/// `v` no faster than `limits.linear` and `limits.angular`. The vector (vx, vy) keeps its direction, however long it
/// is. Passes its own result unchanged.
Velocity within_limits(const Limits& limits, Velocity v);

/// `v` scaled down, all of it alike, so that no wheel rolls faster than `speed` [m/s]: it keeps to its arc, where
/// motors at their limit would straighten it. Passes its own result unchanged.
Velocity within_wheel_speed(const WheelGeometry& wheels, double speed, const Velocity& v);

/// The velocity that an action asks for: its components are shares of the limits, and count as -1 or 1 beyond that.
Velocity scaled_to(const Limits& limits, const Velocity& shares);

/// The velocity on the way from `last` to `target` that one control period allows. Passes its own result unchanged.
Velocity within_acceleration(const Limits& limits, const Velocity& last, const Velocity& target);

}  // namespace threewe
