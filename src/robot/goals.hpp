// Validation of goals.
#pragma once

#include <optional>

#include "threewe/hardware/profile.hpp"
#include "threewe/nav/navigator.hpp"

namespace threewe {

/// Throws ContractError unless every number of a goal is finite and makes sense.
void check_goal(const nav::Goal& goal);
/// Throws ContractError unless a zone is a polygon of finite corners, and its limit positive.
void check_zone(const map::Zone& zone);
/// Throws ContractError unless a velocity is finite and the base can drive it.
void check_velocity(const RobotProfile& profile, const Velocity& velocity);
/// The tolerance [m] of a goal that is a place in `map`; empty for goals relative to where the robot starts.
std::optional<double> tolerance_in_map(const nav::Goal& goal);
/// [m] from where the robot believes it is to where it should be.
double distance_to_goal(const nav::Goal& goal, const Pose2D& map_from_base, const nav::Progress& progress);

}  // namespace threewe
