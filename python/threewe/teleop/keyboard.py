"""Keyboard of a terminal as an input device of teleoperation."""

from __future__ import annotations

import math
import os
import select
import termios
from contextlib import suppress
from typing import Any, Self

from threewe.teleop.events import Command, Connection, Drive, Event, SpeedLevel

FIRST_HOLD = 0.7
"""[s] that a key drives after it was pressed: most terminals repeat it 0.25 to 0.66 s later for the first time."""
REPEAT_HOLD = 0.25
"""[s] that it drives after a repetition; the next one comes within 0.05 s."""
LONGEST_REPEAT = 0.15
"""[s] between two arrivals of a drive key that is held down: terminals repeat it 10 to 40 times a second."""
SAME_PRESS = 0.7
"""[s] between two arrivals of a command's key below which it was held down, not pressed again."""

DRIVE_KEYS = {
    "w": Drive(ahead=1.0),
    "s": Drive(ahead=-1.0),
    "a": Drive(left=1.0),
    "d": Drive(left=-1.0),
    "q": Drive(turn=1.0),
    "e": Drive(turn=-1.0),
    "up": Drive(ahead=1.0),
    "down": Drive(ahead=-1.0),
    "left": Drive(turn=1.0),
    "right": Drive(turn=-1.0),
}
REPEATED_COMMANDS = {"+": Command.faster, "=": Command.faster, "-": Command.slower, " ": Command.stop}
COMMAND_KEYS = {
    "x": Command.emergency_stop,
    "t": Command.hand_back,
    "r": Command.start_episode,
    "\r": Command.end_with_success,
    "\n": Command.end_with_success,
    "f": Command.end_with_failure,
    "\x7f": Command.discard_episode,
    "\b": Command.discard_episode,
    "escape": Command.quit,
    "\x03": Command.quit,  # Ctrl-C, where the terminal makes no signal of it
}
ARROWS = {"A": "up", "B": "down", "C": "right", "D": "left"}


class KeyParser:
    """Keys from the bytes that a terminal sends: characters, arrows and Escape."""

    def __init__(self) -> None:
        self._rest = ""

    def feed(self, data: bytes) -> list[str]:
        """The keys that are complete. Call it without data when nothing came: a lone escape byte is the Escape key."""
        text, self._rest = self._rest + data.decode("latin-1"), ""
        keys, i = [], 0
        while i < len(text):
            if text[i] != "\x1b":
                keys.append(text[i].lower())
                i += 1
            elif i + 1 == len(text) or (text[i + 1] in "[O" and self._end(text, i + 2) is None):
                if data:  # the rest of a sequence may be on its way
                    self._rest = text[i:]
                    break
                keys.append("escape")
                i = len(text)
            elif text[i + 1] in "[O":
                end = self._end(text, i + 2)
                assert end is not None
                if text[end] in ARROWS:
                    keys.append(ARROWS[text[end]])
                i = end + 1
            else:  # Escape, then another key
                keys.append("escape")
                i += 1
        return keys

    @staticmethod
    def _end(text: str, start: int) -> int | None:
        """Where the final byte of a control sequence is; None while it is missing."""
        return next((i for i in range(start, len(text)) if "@" <= text[i] <= "~"), None)


class KeyboardInput:
    """A terminal's keyboard.

    Terminals report that a key is down, again and again, never that it was released. So a key drives for 0.7 s, which
    is longer than the delay of the terminal's own repetition, and 0.25 s more with each repetition: hold a key to
    drive, let go to stop. Directions are kept apart: W, then
    Q in time is a curve. With `latch` a key drives on until the opposite key, space or the end.

    Args:
        fd: the terminal to read, or any other readable descriptor. A terminal is set to deliver each key at once and
            without an echo until `close`.
        latch: keep driving when no key is down.
    """

    def __init__(self, fd: int, *, latch: bool = False) -> None:
        self._fd, self._latch = fd, latch
        self._parser = KeyParser()
        self._axes = dict.fromkeys(("ahead", "left", "turn"), 0.0)
        self._until = dict.fromkeys(self._axes, -math.inf)
        self._pressed: dict[str, float] = {}
        self._drive = Drive()
        self._ended = False
        self._saved = _listen(fd) if os.isatty(fd) else None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def poll(self, now: float) -> list[Event]:
        """See `TeleopInput`. A terminal that is gone asks for nothing and ends the teleoperation."""
        if self._ended:
            return []
        events: list[Event] = []
        data = self._read()
        for key in self._parser.feed(data or b""):
            events += self._press(key, now)
        for axis, until in self._until.items():
            if now >= until:
                self._axes[axis] = 0.0
        if data is None:
            self._ended = True
            self._axes = dict.fromkeys(self._axes, 0.0)
        drive = Drive(**self._axes)
        if drive != self._drive or (drive and data):
            events.append(drive)
        self._drive = drive
        if data is None:
            events += [Connection(False, "the terminal is gone"), Command.quit]
        return events

    def close(self) -> None:
        """Gives the terminal its settings back."""
        if self._saved is not None:
            saved, self._saved = self._saved, None
            with suppress(termios.error, OSError):  # the terminal may be gone
                termios.tcsetattr(self._fd, termios.TCSADRAIN, saved)

    def _read(self) -> bytes | None:
        """What has arrived; None at the end."""
        data = b""
        try:
            while select.select([self._fd], [], [], 0.0)[0]:
                part = os.read(self._fd, 1024)
                if not part:
                    return None
                data += part
                if len(data) >= 65536:
                    break  # a flood must not keep the loop from driving
        except (OSError, ValueError):  # hung up, or closed
            return None
        return data

    def _press(self, key: str, now: float) -> list[Event]:
        before, self._pressed[key] = self._pressed.get(key, -math.inf), now
        if key in DRIVE_KEYS:
            self._steer(DRIVE_KEYS[key], now, now - before)
            return []
        if key in "123456789":
            return [SpeedLevel(int(key))]
        if key in REPEATED_COMMANDS:
            command: Command | None = REPEATED_COMMANDS[key]
        else:
            command = COMMAND_KEYS.get(key) if now - before >= SAME_PRESS else None
        if command in (Command.stop, Command.emergency_stop, Command.hand_back):
            self._axes = dict.fromkeys(self._axes, 0.0)
        return [] if command is None else [command]

    def _steer(self, drive: Drive, now: float, since_last: float) -> None:
        """Sets the axis of a key that arrived `since_last` [s] after it did before."""
        for axis in self._axes:
            if not (value := getattr(drive, axis)):
                continue
            if not self._latch:
                self._axes[axis] = value
                self._until[axis] = now + (REPEAT_HOLD if since_last < LONGEST_REPEAT else FIRST_HOLD)
            elif since_last >= SAME_PRESS:
                opposite = self._axes[axis] * value < 0.0
                self._axes[axis] = 0.0 if opposite else value
                self._until[axis] = math.inf


def _listen(fd: int) -> list[Any]:
    """Each key at once, without an echo; the settings until now."""
    saved = termios.tcgetattr(fd)
    changed = termios.tcgetattr(fd)
    changed[0] &= ~termios.IXON  # Ctrl-S would hold up the screen, and with it the loop that drives
    changed[3] &= ~(termios.ICANON | termios.ECHO)
    changed[6][termios.VSUSP] = b"\0"  # Ctrl-Z would leave a robot without its driver
    termios.tcsetattr(fd, termios.TCSADRAIN, changed)
    return saved
