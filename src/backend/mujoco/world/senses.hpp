// What a robot's sensors read on MuJoCo's physics. All but physics and rays is what `models` says, as in every
// simulator.
#pragma once

#include <cstddef>
#include <vector>

#include "backend/mujoco/world/physics.hpp"
#include "sim/model.hpp"
#include "sim/state.hpp"

namespace threewe::backend::mujoco {

/// Along which unit vectors the points of a turn are taken, in the base frame.
std::vector<exports::Vec3> beams_of(const LidarSpec& lidar);

/// Takes the readings that are due at the end of a step, in which the robot moved as `passage` says. `beams` are its
/// lidar's.
void sense(const sim::RobotModel& robot, const std::vector<exports::Vec3>& beams, std::size_t index,
           const Passage& passage, Physics& physics, sim::RobotState& state);

}  // namespace threewe::backend::mujoco
