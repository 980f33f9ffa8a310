// Results of motions and explorations.
#pragma once

#include <memory>
#include <string>

#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"
#include "threewe/nav/navigator.hpp"

namespace threewe {

using nav::Progress;
using nav::Reason;
using nav::RecoveryState;

/// How a motion ended. `map` frame.
struct MoveResult {
  bool success = false;               ///< `reason` is `reached`
  Reason reason = Reason::running;    ///< why it ended
  std::string detail;                 ///< says more about a failure; may be empty
  Pose2D pose;                        ///< where the robot estimates that it is
  double position_uncertainty = 0.0;  ///< [m] around `pose`, see PoseEstimate::position_uncertainty
  double distance_to_goal = 0.0;      ///< [m], by its own estimate
  double distance = 0.0;              ///< [m] driven, by its own estimate
  double duration = 0.0;              ///< [s] of robot time

  /// Throws the error that matches `reason`; does nothing after success.
  void raise_for_failure() const;
};

/// How an exploration ended.
struct ExploreResult {
  bool success = false;             ///< nothing that can be reached is left to see
  Reason reason = Reason::running;  ///< why it ended
  std::string detail;               ///< says more about a failure; may be empty
  double explored_area = 0.0;       ///< [m^2] known to be free
  double distance = 0.0;            ///< [m]
  double duration = 0.0;            ///< [s] of robot time

  /// Throws the error that matches `reason`; does nothing after success.
  void raise_for_failure() const;
};

}  // namespace threewe
