// A plan without any search: drive at a point of the path ahead.
#pragma once

#include "nav/mppi.hpp"
#include "nav/mppi/path_table.hpp"
#include "nav/mppi/rollout.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe::nav::mppi {

/// See `Params::Follower`, and `path_end` of `Params::Motion`.
struct PursuitParams {
  double lookahead = 0.0;
  double rest = 0.0;
  double position_gain = 0.0;
  double heading_gain = 0.0;
  double turn_first = 0.0;
};

/// The plan that pursues the path from `start`, in `odom`, or turns on the spot. It knows nothing of obstacles; as one
/// of the means that samples vary it shows where to go when the plan before has become useless.
Plan pursue(const PathTable& path, const MppiTask& task, const Limits& limits, Kinematics kinematics, double step,
            const Pose2D& start, const PursuitParams& params);

}  // namespace threewe::nav::mppi
