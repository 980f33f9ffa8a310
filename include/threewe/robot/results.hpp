// Results of motions, explorations and instructions.
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "threewe/core/camera.hpp"
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

/// One argument of a skill.
struct SkillArgument {
  std::string name;                         ///< such as "kind"
  std::variant<std::string, double> value;  ///< [m], [rad] or [s] where it is a number
};

/// One skill that was executed.
struct ExecutedStep {
  std::string skill;                     ///< such as "search"
  std::string text;                      ///< with its arguments: "search(kind=chair, color=red)"
  std::vector<SkillArgument> arguments;  ///< those that were said
  std::string reason;                    ///< how it ended: "done", "not_found", or a motion's reason
  std::string detail;                    ///< says more; may be empty
  double begun = 0.0;                    ///< [s] of robot time
  double ended = 0.0;                    ///< [s]
  std::uint64_t thing = 0;               ///< id of the mapped thing that it rests on; 0: none
  bool verified = false;                 ///< the robot's own detector saw what it says
  Picture picture;                       ///< what the camera showed as it ended; no pixels without a camera
};

/// What became of an instruction.
struct ExecutionResult {
  bool success = false;   ///< `reason` is `done`
  std::string reason;     ///< done, not_found, not_understood, ambiguous, refused, budget, or that of a motion
  std::string detail;     ///< says more about a failure; may be empty
  std::string answer;     ///< to a question, or what was found, as a sentence; may be empty
  bool verified = false;  ///< the robot's own detector saw what the answer says
  std::vector<ExecutedStep> steps;  ///< the skills that were executed
  double distance = 0.0;            ///< [m] driven, by its own estimate
  double duration = 0.0;            ///< [s] of robot time
};

}  // namespace threewe
