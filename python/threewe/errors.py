"""What 3we raises. A failed action in the world is no exception but a result with a reason."""

import builtins


class ThreeweError(Exception):
    """The base of every error that 3we raises on purpose."""


class ConnectionError(ThreeweError, builtins.ConnectionError):
    """The robot is not connected, or the connection was lost."""


class HardwareError(ThreeweError):
    """The robot lacks the sensor or actuator that was asked for."""


class NavigationError(ThreeweError):
    """A motion ended without reaching its goal (raised by `raise_for_failure`)."""


class SafetyError(ThreeweError):
    """The request was refused to keep the robot safe, such as a second owner."""


class EmergencyStopError(SafetyError):
    """A motion was asked for while the emergency stop is latched."""


class TimeoutError(ThreeweError, builtins.TimeoutError):
    """Robot time ran out."""


class ContractError(ThreeweError, ValueError):
    """A value broke the contract: NaN, a wrong shape, `vy` on a differential base."""


class RecordingError(ThreeweError, OSError):
    """A recording could not be written; the message names the file, and what is safe."""


class ConfigError(ThreeweError, ValueError):
    """A scene, profile, option or file is wrong; the message says where, and what would be right."""
