"""Gamepad of Linux as an input device of teleoperation.

It reads `struct input_event` itself: the package `evdev` has no wheels, so that it would need a compiler and kernel
headers on every robot.
"""

from __future__ import annotations

import fcntl
import math
import os
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from threewe.errors import ConfigError
from threewe.teleop.events import Command, Connection, Drive, Event

EVENT = struct.Struct("llHHi")  # seconds, microseconds, type, code, value: 24 bytes on 64-bit machines
ABSOLUTE_AXIS = struct.Struct("6i")  # value, minimum, maximum, fuzz, flat, resolution
EV_SYN, EV_KEY, EV_ABS = 0, 1, 3
SYN_DROPPED = 3
BTN_GAMEPAD = 0x130
ABS_X, ABS_Y, ABS_Z, ABS_RX, ABS_HAT0Y = 0, 1, 2, 3, 17

BUTTONS = {
    0x130: Command.stop,  # A, cross
    0x131: Command.emergency_stop,  # B, circle
    0x133: Command.hand_back,  # X of an Xbox pad, triangle
    0x134: Command.discard_episode,  # Y of an Xbox pad, square
    0x136: Command.slower,  # left shoulder
    0x137: Command.faster,  # right shoulder
    0x13A: Command.end_with_failure,  # select
    0x13B: Command.start_episode,  # start
    0x13C: Command.quit,  # the maker's
    0x13D: Command.stop,  # left stick
    0x13E: Command.end_with_success,  # right stick
}
DEAD_ZONE = 0.1
"""Of the way from the middle of an axis to its end, at least: sticks do not come back to the middle exactly."""
SECONDS_BETWEEN_TRIES = 0.5
"""[s] between two attempts to find a gamepad again."""


@dataclass(frozen=True)
class AxisRange:
    """What the values of an axis mean."""

    minimum: int = -32768
    maximum: int = 32767
    flat: int = 0
    """Around the middle: values that mean nothing."""

    def normalized(self, value: int) -> float:
        """-1 to 1; 0 in the dead zone, and from there on without a jump."""
        half = 0.5 * (self.maximum - self.minimum)
        if half <= 0.0:
            return 0.0
        share = (value - 0.5 * (self.maximum + self.minimum)) / half
        dead = min(max(DEAD_ZONE, self.flat / half), 0.9)
        return math.copysign(min(1.0, max(0.0, (abs(share) - dead) / (1.0 - dead))), share)


class GamepadInput:
    """A gamepad: the left stick drives, the right one turns, the cross chooses the speed.

    When it is unplugged, one `Connection` says so, and the directions are zero; it is looked for until it is there
    again.

    Args:
        path: its device, /dev/input/event*; the first gamepad of the machine where left out.
        system: where the kernel lists input devices.

    Raises:
        ConfigError: there is none, or it cannot be read.
    """

    def __init__(self, path: Path | None = None, *, system: Path = Path("/sys/class/input")) -> None:
        self._wanted, self._system = path, system
        self._fd: int | None = None
        self._connected = True
        self._next_try = -math.inf
        self._rest = b""
        self._values: dict[int, float] = {}
        self._reported = Drive()
        self._open(self._find())

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def poll(self, now: float) -> list[Event]:
        """See `TeleopInput`."""
        if self._fd is None and not self._reopen(now):
            return []
        data = self._read()
        if data is None:
            return self._lose(now)
        events: list[Event] = []
        if not self._connected:
            self._connected = True
            events.append(Connection(True, "the gamepad is there again"))
        self._rest += data
        whole = len(self._rest) // EVENT.size * EVENT.size
        for _, _, kind, code, value in EVENT.iter_unpack(self._rest[:whole]):
            events += self._take(kind, code, value)
        self._rest = self._rest[whole:]
        drive = self._drive()
        if drive != self._reported:
            events.append(drive)
            self._reported = drive
        return events

    def close(self) -> None:
        """Lets go of the device."""
        if self._fd is not None:
            os.close(self._fd)
            self._fd = None

    def _find(self) -> Path:
        if self._wanted is not None:
            return self._wanted
        found = find_gamepads(self._system)
        if not found:
            raise ConfigError("no gamepad found; plug one in, or name its device with --device /dev/input/event*")
        return found[0]

    def _open(self, path: Path) -> None:
        try:
            self._fd = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
        except PermissionError:
            raise ConfigError(
                f"{path}: no permission to read the gamepad; add yourself to its group: sudo usermod -aG input $USER"
            ) from None
        except OSError as error:
            raise ConfigError(f"{path}: the gamepad cannot be opened: {error.strerror}") from None
        self._rest, self._values, self._reported = b"", {}, Drive()
        self._ranges = {code: _axis_range(self._fd, code) for code in (ABS_X, ABS_Y, ABS_Z, ABS_RX)}
        # By the kernel's rules the right stick is RX; pads without it have it at Z.
        self._turn = ABS_RX if self._ranges[ABS_RX] or not self._ranges[ABS_Z] else ABS_Z

    def _reopen(self, now: float) -> bool:
        if now < self._next_try:
            return False
        self._next_try = now + SECONDS_BETWEEN_TRIES
        try:
            self._open(self._find())
        except ConfigError:
            return False
        return True

    def _read(self) -> bytes | None:
        """What has arrived; None where the device is gone."""
        assert self._fd is not None
        try:
            return os.read(self._fd, 256 * EVENT.size) or None
        except BlockingIOError:
            return b""
        except OSError:  # ENODEV
            return None

    def _lose(self, now: float) -> list[Event]:
        self.close()
        self._next_try = now + SECONDS_BETWEEN_TRIES
        if not self._connected:
            return []
        self._connected = False
        return [Drive(), Connection(False, "the gamepad is unplugged, the robot stops: plug it in again")]

    def _take(self, kind: int, code: int, value: int) -> list[Event]:
        if kind == EV_SYN and code == SYN_DROPPED:
            self._values.clear()  # some events were lost: where the sticks are is not known until they move
        elif kind == EV_ABS and code == ABS_HAT0Y and value:
            return [Command.faster if value < 0 else Command.slower]
        elif kind == EV_ABS and code in self._ranges:
            self._values[code] = (self._ranges[code] or AxisRange()).normalized(value)
        elif kind == EV_KEY and value == 1 and code in BUTTONS:
            return [BUTTONS[code]]
        return []

    def _drive(self) -> Drive:
        # Sticks count to the right and towards the person; adding zero makes -0.0 the same as 0.0.
        ahead, left, turn = (0.0 - self._values.get(code, 0.0) for code in (ABS_Y, ABS_X, self._turn))
        return Drive(ahead, left, turn)


def find_gamepads(system: Path = Path("/sys/class/input")) -> list[Path]:
    """The devices /dev/input/event* that have a gamepad's buttons, in the order of their numbers."""
    found = []
    for entry in system.glob("event*"):
        try:
            words = (entry / "device" / "capabilities" / "key").read_text().split()
            bits = sum(int(word, 16) << (64 * i) for i, word in enumerate(reversed(words)))
            if bits >> BTN_GAMEPAD & 1:
                found.append((int(entry.name.removeprefix("event")), Path("/dev/input") / entry.name))
        except (OSError, ValueError):
            continue
    return [path for _, path in sorted(found)]


def axis_request(code: int) -> int:
    """The number of the system call EVIOCGABS for an axis: reads 24 bytes, of group E, from 0x40 on."""
    return 2 << 30 | ABSOLUTE_AXIS.size << 16 | ord("E") << 8 | 0x40 + code


def _axis_range(fd: int, code: int) -> AxisRange | None:
    """The calibration of an axis by EVIOCGABS; None where the device has no such axis, or is no input device."""
    try:
        answer = fcntl.ioctl(fd, axis_request(code), bytes(ABSOLUTE_AXIS.size))
    except OSError:
        return None
    _, minimum, maximum, _, flat, _ = ABSOLUTE_AXIS.unpack(answer)
    return AxisRange(minimum, maximum, flat) if maximum > minimum else None
