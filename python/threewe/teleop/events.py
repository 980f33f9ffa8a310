"""What input devices of teleoperation report: where the person drives, and commands."""

from __future__ import annotations

import enum
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Protocol, TypeAlias


@dataclass(frozen=True)
class Drive:
    """The direction that a person asks for, as fractions of the speed that is chosen.

    It holds until the device reports another one.
    """

    ahead: float = 0.0
    """-1 (back) to 1"""
    left: float = 0.0
    """-1 (right) to 1"""
    turn: float = 0.0
    """-1 (clockwise) to 1"""

    def __bool__(self) -> bool:
        return any((self.ahead, self.left, self.turn))

    def __add__(self, other: Drive) -> Drive:
        """Both at once; each component stays within [-1, 1]."""
        return Drive(
            *(
                max(-1.0, min(1.0, a + b))
                for a, b in ((self.ahead, other.ahead), (self.left, other.left), (self.turn, other.turn))
            )
        )


@dataclass(frozen=True)
class SpeedLevel:
    """The speed that is chosen: 1 (slowest) to 9 (the operating limits)."""

    level: int


class Command(enum.StrEnum):
    """What a key or a button asks for, beside driving."""

    faster = "faster"
    slower = "slower"
    stop = "stop"
    """Stand still; a person drives from now on."""
    emergency_stop = "emergency_stop"
    """Latch the emergency stop, or release it where it is latched."""
    hand_back = "hand_back"
    """Let the policy drive again."""
    start_episode = "start_episode"
    end_with_success = "end_with_success"
    end_with_failure = "end_with_failure"
    discard_episode = "discard_episode"
    quit = "quit"


@dataclass(frozen=True)
class Connection:
    """An input device was lost, or is there again. A lost one asks for nothing."""

    connected: bool
    message: str
    """For the person, one line."""


Event: TypeAlias = Drive | SpeedLevel | Command | Connection
"""What an input device reports."""


class TeleopInput(Protocol):
    """An input device. `teleoperate` polls it before every control period."""

    def poll(self, now: float) -> Sequence[Event]:
        """What has happened since the last call, oldest first; returns at once.

        Args:
            now: [s], rises from call to call: robot time.
        """

    def close(self) -> None:
        """Leaves the device as it was found. Twice is as good as once."""


class CombinedInput:
    """Several input devices as one: their directions add up."""

    def __init__(self, sources: Sequence[TeleopInput]) -> None:
        """`sources` are closed with it."""
        self._sources = list(sources)
        self._drives = [Drive() for _ in self._sources]

    def poll(self, now: float) -> list[Event]:
        """The events of all of them, see `TeleopInput`."""
        events: list[Event] = []
        for i, source in enumerate(self._sources):
            for event in source.poll(now):
                if isinstance(event, Drive):
                    self._drives[i] = event
                    event = sum(self._drives, Drive())
                events.append(event)
        return events

    def has(self, kind: type) -> bool:
        """Whether a device of this class is among them."""
        return any(isinstance(source, kind) for source in self._sources)

    def close(self) -> None:
        """Closes all of them, also where one fails."""
        with ExitStack() as stack:
            for source in self._sources:
                stack.callback(source.close)
