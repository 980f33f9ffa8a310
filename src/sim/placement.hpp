// Placement check: where a robot can be put down.
#pragma once

#include <optional>
#include <string>

#include "sim/model.hpp"

namespace threewe::sim {

/// What a robot at `pose` would stand in: the name of an object, or "a wall"; nothing where it is free.
std::optional<std::string> find_collision(const Model& model, std::size_t robot, const Pose2D& pose);

/// Whether two robots would overlap.
bool robots_overlap(const RobotModel& a, const Pose2D& pose_a, const RobotModel& b, const Pose2D& pose_b);

}  // namespace threewe::sim
