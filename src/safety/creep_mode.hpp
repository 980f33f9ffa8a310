// Creep mode: driving so slowly that a touch does no harm, with less margin where the body is measured to pass.
#pragma once

#include <span>
#include <vector>

#include "safety/gate.hpp"

namespace threewe::safety {

/// The operating limits, and no corner faster than `Params::Creep::corner_speed`.
Limits creep_limits(const GateModel& model);

/// Whether no command that the robot has yet to obey, or is still slowing down from, is faster than that.
bool is_creeping(const GateModel& model, const GateState& state);

/// Whether the margin around the robot is not free, where it is.
bool is_in_passage(const GateModel& model, std::span<const Vec2> hits, const Pose2D& odom_from_base);

/// What is around the robot, in its frame, hits without noise: a hit's noise alone would close a narrow passage.
struct Passage {
  std::vector<Vec2> ahead;    ///< what the body would run into, straight on: it keeps the whole margin
  std::vector<Vec2> beside;   ///< what the body passes: it keeps the margin of creep mode
  std::vector<Vec2> assumed;  ///< the same, where something may be
};

/// The passage that leads along `velocity`, measured by the hits of a scan. Between ends that leave hardly more than
/// the margin before and behind the body it has no way but to turn by small moves: then all that is near is beside it.
Passage measure_passage(const GateModel& model, const Velocity& velocity, const Surroundings& surroundings,
                        const Pose2D& odom_from_base);

}  // namespace threewe::safety
