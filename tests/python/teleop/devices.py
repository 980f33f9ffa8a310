"""Input devices that the tests play: a terminal, a gamepad, and keys pressed at given robot times."""

from __future__ import annotations

import fcntl
import os
import pty
import select
import struct
import termios
from collections.abc import Callable, Mapping
from pathlib import Path

from threewe.teleop import Event, TeleopInput
from threewe.teleop.gamepad import EVENT

ABS_X, ABS_Y, ABS_RX, HAT_Y = 0, 1, 3, 17
A, B, X, START = 0x130, 0x131, 0x133, 0x13B


class Terminal:
    """A pseudo-terminal: the test types, the code under test reads `fd`."""

    def __init__(self) -> None:
        self._keys, self.fd = pty.openpty()

    def press(self, keys: str) -> None:
        """Returns when all of them can be read."""
        before = self._waiting()
        os.write(self._keys, keys.encode())
        while self._waiting() < before + len(keys):
            select.select([self.fd], [], [], 0.1)

    def hang_up(self) -> None:
        os.close(self._keys)

    def close(self) -> None:
        os.close(self.fd)

    def _waiting(self) -> int:
        (count,) = struct.unpack("i", fcntl.ioctl(self.fd, termios.FIONREAD, bytes(4)))
        return int(count)


class VirtualGamepad:
    """A pipe that sends what the kernel would. It is plugged in while it is open for writing."""

    def __init__(self, path: Path) -> None:
        self.path = path
        os.mkfifo(path)
        self._fd = -1

    def plug(self) -> None:
        self._fd = os.open(self.path, os.O_RDWR | os.O_NONBLOCK)

    def unplug(self) -> None:
        os.close(self._fd)

    def send(self, kind: int, code: int, value: int) -> None:
        os.write(self._fd, EVENT.pack(0, 0, kind, code, value) + EVENT.pack(0, 0, 0, 0, 0))

    def move(self, axis: int, share: float) -> None:
        """-1 to 1: right and towards the person are positive."""
        self.send(3, axis, round(share * 32767.5 - 0.5))

    def press(self, button: int) -> None:
        self.send(1, button, 1)
        self.send(1, button, 0)


class Scripted:
    """A device, with what the person does at given times [s] after the first poll."""

    def __init__(self, source: TeleopInput, script: Mapping[float, Callable[[], object]]) -> None:
        self._source, self._script = source, sorted(script.items(), key=lambda entry: entry[0])
        self._began: float | None = None

    def poll(self, now: float) -> list[Event]:
        self._began = now if self._began is None else self._began
        while self._script and now - self._began >= self._script[0][0] - 1e-9:
            self._script.pop(0)[1]()
        return list(self._source.poll(now))

    def close(self) -> None:
        self._source.close()
