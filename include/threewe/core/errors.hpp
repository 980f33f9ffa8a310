// Exception hierarchy of the library. A failed action in the world is no exception but a result with a reason.
#pragma once

#include <stdexcept>
#include <string>

namespace threewe {

/// The base of every error that 3we raises on purpose.
class ThreeweError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The robot is not connected, or the connection was lost.
class ConnectionError : public ThreeweError {
  using ThreeweError::ThreeweError;
};
/// The robot lacks the sensor or actuator that was asked for.
class HardwareError : public ThreeweError {
  using ThreeweError::ThreeweError;
};
/// A motion ended without reaching its goal (raised by `raise_for_failure`).
class NavigationError : public ThreeweError {
  using ThreeweError::ThreeweError;
};
/// The request was refused to keep the robot safe, such as a second owner.
class SafetyError : public ThreeweError {
  using ThreeweError::ThreeweError;
};
/// A motion was asked for while the emergency stop is latched.
class EmergencyStopError : public SafetyError {
  using SafetyError::SafetyError;
};
/// Robot time ran out.
class TimeoutError : public ThreeweError {
  using ThreeweError::ThreeweError;
};
/// A value broke the contract: NaN, a wrong shape, `vy` on a differential base.
class ContractError : public ThreeweError {
  using ThreeweError::ThreeweError;
};
/// A recording could not be written; the message names the file, and what is safe.
class RecordingError : public ThreeweError {
  using ThreeweError::ThreeweError;
};
/// A scene, profile, option or file is wrong; the message names file:line or field, and what would be right.
class ConfigError : public ThreeweError {
  using ThreeweError::ThreeweError;
};

}  // namespace threewe
