#include "threewe/nav/navigator.hpp"

namespace threewe::nav {

std::string_view to_string(Reason reason) {
  switch (reason) {
    case Reason::running: return "running";
    case Reason::reached: return "reached";
    case Reason::no_path: return "no_path";
    case Reason::blocked: return "blocked";
    case Reason::timeout: return "timeout";
    case Reason::cancelled: return "cancelled";
    case Reason::estop: return "estop";
    case Reason::lost: return "lost";
    case Reason::uncertain: return "uncertain";
    case Reason::fault: return "fault";
    case Reason::starved: return "starved";
    case Reason::policy_error: return "policy_error";
  }
  return "unknown";
}

std::string_view to_string(RecoveryState state) {
  switch (state) {
    case RecoveryState::driving: return "driving";
    case RecoveryState::clearing: return "clearing";
    case RecoveryState::backing_off: return "backing_off";
    case RecoveryState::arc_escape: return "arc_escape";
    case RecoveryState::looking: return "looking";
    case RecoveryState::replanning: return "replanning";
    case RecoveryState::given_up: return "given_up";
  }
  return "unknown";
}

}  // namespace threewe::nav
