#include "threewe/robot/results.hpp"

#include "threewe/core/errors.hpp"

namespace threewe {
namespace {

void raise(const char* what, Reason reason, const std::string& detail) {
  const std::string message = std::string(what) + " ended with '" + std::string(to_string(reason)) + "'" +
                              (detail.empty() ? "" : ": " + detail);
  switch (reason) {
    case Reason::running:
    case Reason::reached: return;
    case Reason::timeout: throw TimeoutError(message);
    case Reason::estop: throw EmergencyStopError(message);
    case Reason::fault: throw HardwareError(message);
    case Reason::no_path:
    case Reason::blocked:
    case Reason::cancelled:
    case Reason::lost:
    case Reason::uncertain:
    case Reason::starved:
    case Reason::policy_error: throw NavigationError(message);
  }
}

}  // namespace

void MoveResult::raise_for_failure() const {
  if (!success) raise("the motion", reason, detail);
}

void ExploreResult::raise_for_failure() const {
  if (!success) raise("the exploration", reason, detail);
}

}  // namespace threewe
