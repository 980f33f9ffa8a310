// Simulation step, for one world or many.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "sim/model.hpp"
#include "sim/people.hpp"
#include "sim/state.hpp"

namespace threewe::sim {

/// A robot that stands at `pose` (scene frame) as an episode begins. `robot` is its place in the model.
RobotState begin(const Model& model, std::size_t robot, const Pose2D& pose, std::uint64_t seed,
                 std::uint32_t episode = 0, const models::Variation& variation = {});

/// Changes how a robot differs from its profile, from its next step on, in what need not stay for an episode.
void vary(const RobotModel& robot, const models::Variation& variation, RobotState& state);

/// After what time a reading arrives that takes `latency` by the profile: a whole number of steps.
Duration varied_latency(Duration latency, const models::Variation& variation);

/// Which sensors work in a step. Leaving one out changes nothing that others measure, nor how anything moves; a scan is
/// whole only if its lidar worked in every step of the turn. With `lidar_reach` [m], what stands farther from the lidar
/// may be left out: points up to there are the same to the bit.
struct Sensing {
  bool lidar = true;
  double lidar_reach = RayCaster::kEverything;
  bool imu = true;
  bool odometry = true;
  bool ultrasonics = true;
};

/// One world, and the commands of its robots at the beginning of a step.
struct World {
  const Model* model = nullptr;
  std::span<RobotState> robots;        ///< the model's, in order
  std::span<const Velocity> commands;  ///< body velocities, one for each robot
  std::span<PersonState> people;       ///< the scene's; empty: there are none
  Sensing sensing;
  /// Of a robot that is alone with no people: where it is as a turn of its lidar begins, and after each step of it; as
  /// many poses as a turn has steps, and one. Empty: not kept.
  std::span<Pose2D> path = {};
};

/// Advances every world by `steps` times `kStep`, under the same commands. Worlds do not influence each other, so any
/// part of a batch may be stepped on its own, on any thread, in any order, with the same bits; several at once are
/// faster, and so are several steps.
void step(std::span<const World> worlds, int steps = 1);

/// The same for worlds of one model, whose states, commands and people stand one world behind the other.
void step(const Model& model, std::span<RobotState> states, std::span<const Velocity> commands,
          std::span<PersonState> people = {});

/// What became ready in the last step: readings are complete at the step's end, before any latency.
bool imu_ready(const RobotModel& robot, const RobotState& state);
bool odometry_ready(const RobotModel& robot, const RobotState& state);
/// In the first step too: one reading tells all about a battery, and no caller waits a period for it.
bool battery_ready(const RobotModel& robot, const RobotState& state);
/// The sensor, counted in the order of the profile's mounts, whose ping has just been heard.
std::optional<std::size_t> ping_ready(const RobotModel& robot, const RobotState& state);
bool scan_ready(const RobotModel& robot, const RobotState& state);
/// The points of the turn that just ended, in the order in which they were taken; only while `scan_ready`.
std::span<const float> scan_points(const RobotModel& robot, const RobotState& state);
/// The points of turn number `turn` (from 0) of this episode, by the path that was kept, wherever the robot is by now:
/// the same to the bit up to `reach` [m], as long as its variation is the same.
void retake_scan(const RobotModel& robot, const RobotState& state, std::uint64_t turn, std::span<const Pose2D> path,
                 double reach, std::span<float> points);

}  // namespace threewe::sim
