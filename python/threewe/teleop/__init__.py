"""Teleoperation: a person drives a robot by keyboard or gamepad, also in place of a policy that errs."""

from threewe.teleop.controls import Controls
from threewe.teleop.events import CombinedInput, Command, Connection, Drive, Event, SpeedLevel, TeleopInput
from threewe.teleop.gamepad import GamepadInput, find_gamepads
from threewe.teleop.keyboard import KeyboardInput
from threewe.teleop.loop import Driver, EpisodeRecorder, Status, teleoperate

__all__ = [
    "CombinedInput",
    "Command",
    "Connection",
    "Controls",
    "Drive",
    "Driver",
    "EpisodeRecorder",
    "Event",
    "GamepadInput",
    "KeyboardInput",
    "SpeedLevel",
    "Status",
    "TeleopInput",
    "find_gamepads",
    "teleoperate",
]
