"""`threewe teleop` in a terminal, as someone who types it sees it."""

from __future__ import annotations

import os
import pty
import select
import signal
import subprocess
import sys
import termios
from collections.abc import Iterator
from typing import Any

import pytest


class Session:
    """The command in a pseudo-terminal of its own."""

    def __init__(self, *arguments: str) -> None:
        self._keys, screen = pty.openpty()
        self.before = termios.tcgetattr(screen)
        self._screen = screen
        self.text = ""
        program = "from threewe.cli import main; main()"
        self.process = subprocess.Popen(
            [sys.executable, "-c", program, "teleop", "--scene", "corridor_v1", *arguments],
            stdin=screen,
            stdout=screen,
            stderr=screen,
            start_new_session=True,
            env={**os.environ, "TERM": "xterm", "COLUMNS": "120", "LINES": "40"},
        )

    def wait_for(self, text: str) -> None:
        """Reads until the screen has shown a text that it had not shown before."""
        seen = ""
        while text not in seen:
            assert select.select([self._keys], [], [], 60.0)[0], self.text
            part = os.read(self._keys, 65536).decode(errors="replace")
            seen += part
            self.text += part

    def press(self, keys: str) -> None:
        os.write(self._keys, keys.encode())

    def end(self) -> int:
        """The exit code; what is still to be shown is read, so that the program need not wait."""
        while self.process.poll() is None:
            self._read(0.1)
        while self._read(0.0):
            pass
        return self.process.returncode

    def _read(self, patience: float) -> bool:
        """Reads what is to be shown, if anything is within so many seconds."""
        ready = bool(select.select([self._keys], [], [], patience)[0])
        if ready:
            self.text += os.read(self._keys, 65536).decode(errors="replace")
        return ready

    @property
    def settings(self) -> list[Any]:
        return termios.tcgetattr(self._screen)

    def close(self) -> None:
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()
        os.close(self._keys)
        os.close(self._screen)


@pytest.fixture
def sessions() -> Iterator[list[Session]]:
    opened: list[Session] = []
    yield opened
    for session in opened:
        session.close()


def test_a_drive_in_a_terminal(sessions: list[Session]) -> None:
    session = Session("--input", "keyboard", "--latch", "--speed", "9")
    sessions.append(session)
    session.wait_for("Esc end")
    assert session.settings[3] & termios.ECHO == 0
    session.press("w")
    session.wait_for("ahead +0.50")
    session.press(" ")
    session.wait_for("ahead +0.00")
    session.press("x")
    session.wait_for("EMERGENCY STOP")
    session.press("\x1b")
    assert session.end() == 0, session.text
    assert session.settings == session.before
    assert session.text.endswith("\x1b[?25h")  # the cursor is there again
    assert "Traceback" not in session.text


@pytest.mark.parametrize(("number", "code"), [(signal.SIGTERM, 143), (signal.SIGINT, 0), (signal.SIGHUP, 129)])
def test_the_terminal_is_restored_when_it_is_ended(sessions: list[Session], number: int, code: int) -> None:
    session = Session("--input", "keyboard", "--latch")
    sessions.append(session)
    session.wait_for("Esc end")
    session.press("w")
    session.wait_for("ahead +0.28")
    session.process.send_signal(number)
    assert session.end() == code, session.text
    assert session.settings == session.before
    assert "Traceback" not in session.text


def test_the_terminal_is_restored_when_ctrl_c_is_pressed_again_and_again(sessions: list[Session]) -> None:
    session = Session("--input", "keyboard", "--latch")
    sessions.append(session)
    session.wait_for("Esc end")
    session.press("w")
    session.wait_for("ahead +0.28")
    for _ in range(3):
        session.process.send_signal(signal.SIGINT)
    session.end()
    assert session.settings == session.before


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--input", "keyboard"], "the keyboard drives only in a terminal"),
        (["--input", "gamepad", "--device", "/dev/input/event999"], "event999: the gamepad cannot be opened"),
        (["--input", "keyboard", "--device", "/dev/input/event999"], "--device names a gamepad"),
        (["--scene", "ofice_v2"], "did you mean 'office_v2'?"),
    ],
)
def test_what_cannot_be_driven_is_one_line(arguments: list[str], message: str) -> None:
    program = "from threewe.cli import main; main()"
    command = [sys.executable, "-c", program, "teleop", *arguments]
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True)
    assert done.returncode == 2
    assert message in done.stderr.replace("\n", "")
    assert "Traceback" not in done.stderr
