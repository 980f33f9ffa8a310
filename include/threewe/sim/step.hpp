// The simulator's one step, for one world or many.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "threewe/sim/model.hpp"
#include "threewe/sim/people.hpp"
#include "threewe/sim/state.hpp"

namespace threewe::sim {

/// A robot that stands at `pose` (scene frame) as an episode begins. `robot` is its place in the model.
RobotState begin(const Model& model, std::size_t robot, const Pose2D& pose, std::uint64_t seed,
                 std::uint32_t episode = 0);

/// Advances every robot of every world by `kStep`. `states` holds the worlds one after the other, each with the model's
/// robots in order; `commands` are the body velocities sent at the beginning of the step, one for each state. Worlds do
/// not influence each other, so any part of a batch may be stepped on its own, on any thread. `people` are those of the
/// scene, world by world like the robots; nobody walks where it is empty.
void step(const Model& model, std::span<RobotState> states, std::span<const Velocity> commands,
          std::span<PersonState> people = {});

/// What became ready in the last step: readings are complete at the step's end, before any latency.
bool imu_ready(const RobotModel& robot, const RobotState& state);
bool odometry_ready(const RobotModel& robot, const RobotState& state);
bool battery_ready(const RobotModel& robot, const RobotState& state);
/// The sensor, counted in the order of the profile's mounts, whose ping has just been heard.
std::optional<std::size_t> ping_ready(const RobotModel& robot, const RobotState& state);
bool scan_ready(const RobotModel& robot, const RobotState& state);
/// The points of the turn that just ended, in the order in which they were taken; only while `scan_ready`.
std::span<const float> scan_points(const RobotModel& robot, const RobotState& state);

}  // namespace threewe::sim
