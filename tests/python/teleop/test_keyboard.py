"""Keys of a terminal, typed into a pseudo-terminal."""

from __future__ import annotations

import termios
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pytest
from teleop.devices import Terminal
from threewe.teleop import Command, Connection, Drive, KeyboardInput, SpeedLevel
from threewe.teleop.keyboard import KeyParser


@pytest.fixture
def terminal() -> Iterator[Terminal]:
    made = Terminal()
    yield made
    made.close()


def test_a_key_drives_for_a_while_and_no_longer(terminal: Terminal) -> None:
    with KeyboardInput(terminal.fd) as keyboard:
        assert keyboard.poll(0.0) == []
        terminal.press("w")
        assert keyboard.poll(1.0) == [Drive(ahead=1.0)]
        assert keyboard.poll(1.69) == []
        assert keyboard.poll(1.7) == [Drive()]


def test_a_key_that_is_held_down_drives_until_it_is_released(terminal: Terminal) -> None:
    with KeyboardInput(terminal.fd) as keyboard:
        for now in [0.0, *np.arange(0.5, 3.0, 0.04)]:  # a terminal repeats it after 0.5 s, every 0.04 s
            terminal.press("w")
            assert keyboard.poll(float(now)) == [Drive(ahead=1.0)]
        assert keyboard.poll(float(now) + 0.24) == []
        assert keyboard.poll(float(now) + 0.26) == [Drive()]


def test_two_keys_make_a_curve(terminal: Terminal) -> None:
    with KeyboardInput(terminal.fd) as keyboard:
        terminal.press("w")
        keyboard.poll(0.0)
        terminal.press("q")
        assert keyboard.poll(0.3) == [Drive(ahead=1.0, turn=1.0)]
        assert keyboard.poll(0.7) == [Drive(turn=1.0)]


@pytest.mark.parametrize(
    ("keys", "drive"),
    [
        ("s", Drive(ahead=-1.0)),
        ("A", Drive(left=1.0)),
        ("d", Drive(left=-1.0)),
        ("e", Drive(turn=-1.0)),
        ("\x1b[A", Drive(ahead=1.0)),
        ("\x1bOD", Drive(turn=1.0)),
        ("ws", Drive(ahead=-1.0)),
    ],
)
def test_every_key_has_its_direction(terminal: Terminal, keys: str, drive: Drive) -> None:
    with KeyboardInput(terminal.fd) as keyboard:
        terminal.press(keys)
        assert keyboard.poll(0.0) == [drive]


def test_space_stops_at_once(terminal: Terminal) -> None:
    with KeyboardInput(terminal.fd) as keyboard:
        terminal.press("w")
        keyboard.poll(0.0)
        terminal.press(" ")
        assert keyboard.poll(0.1) == [Command.stop, Drive()]


def test_a_latched_key_drives_until_the_opposite_or_space(terminal: Terminal) -> None:
    with KeyboardInput(terminal.fd, latch=True) as keyboard:
        terminal.press("w")
        keyboard.poll(0.0)
        assert keyboard.poll(99.0) == []
        terminal.press("s")
        assert keyboard.poll(100.0) == [Drive()]
        terminal.press("s")  # held down: not yet back
        assert keyboard.poll(100.3) == []
        terminal.press("s")
        assert keyboard.poll(102.0) == [Drive(ahead=-1.0)]
        terminal.press(" ")
        assert keyboard.poll(103.0) == [Command.stop, Drive()]


def test_commands_come_once_however_long_the_key_is_held(terminal: Terminal) -> None:
    with KeyboardInput(terminal.fd) as keyboard:
        seen = []
        for now in [0.0, *np.arange(0.5, 2.0, 0.04)]:
            terminal.press("x")
            seen += keyboard.poll(float(now))
        assert seen == [Command.emergency_stop]
        terminal.press("x")
        assert keyboard.poll(5.0) == [Command.emergency_stop]


@pytest.mark.parametrize(
    ("key", "event"),
    [
        ("r", Command.start_episode),
        ("\r", Command.end_with_success),
        ("f", Command.end_with_failure),
        ("\x7f", Command.discard_episode),
        ("t", Command.hand_back),
        ("+", Command.faster),
        ("-", Command.slower),
        ("7", SpeedLevel(7)),
    ],
)
def test_every_command_has_its_key(terminal: Terminal, key: str, event: object) -> None:
    with KeyboardInput(terminal.fd) as keyboard:
        terminal.press(key)
        assert keyboard.poll(0.0) == [event]
        terminal.press("?z\x1b[5~")
        assert keyboard.poll(1.0) == []


def test_escape_alone_ends_and_an_arrow_in_pieces_does_not(terminal: Terminal) -> None:
    with KeyboardInput(terminal.fd) as keyboard:
        terminal.press("\x1b")
        assert keyboard.poll(0.0) == []
        terminal.press("[B")
        assert keyboard.poll(0.02) == [Drive(ahead=-1.0)]
        terminal.press("\x1b")
        keyboard.poll(1.0)
        assert Command.quit in keyboard.poll(1.02)


def test_a_terminal_that_is_gone_stops_the_robot_and_ends() -> None:
    terminal = Terminal()
    keyboard = KeyboardInput(terminal.fd, latch=True)
    terminal.press("w")
    assert keyboard.poll(0.0) == [Drive(ahead=1.0)]
    terminal.hang_up()
    lost = keyboard.poll(0.1)
    assert lost[0] == Drive()
    assert isinstance(lost[1], Connection)
    assert lost[2:] == [Command.quit]
    assert keyboard.poll(0.2) == []
    keyboard.close()
    terminal.close()


def test_the_terminal_gets_its_settings_back_also_after_an_exception(terminal: Terminal) -> None:
    before = termios.tcgetattr(terminal.fd)
    keyboard = KeyboardInput(terminal.fd)
    assert termios.tcgetattr(terminal.fd)[3] & (termios.ICANON | termios.ECHO) == 0
    with pytest.raises(ZeroDivisionError), keyboard:
        _ = 1 / 0
    assert termios.tcgetattr(terminal.fd) == before
    keyboard.close()


@pytest.mark.parametrize("seed", range(200))
def test_the_same_keys_however_the_bytes_are_cut(seed: int) -> None:
    rng = np.random.default_rng(seed)
    pieces = ["w", "\x1b[A", "\x1bOB", "\x1b[1;5C", "\x1b[5~", " ", "\r", "é"]
    data = "".join(rng.choice(pieces, 12)).encode()
    whole = KeyParser().feed(data)
    cuts = [0, *sorted(rng.integers(0, len(data), 5).tolist()), len(data)]
    parser = KeyParser()
    cut = [key for a, b in pairwise(cuts) if a < b for key in parser.feed(data[a:b])]
    assert cut == whole, f"seed {seed}"


@pytest.mark.parametrize("seed", range(50))
def test_no_bytes_break_the_keyboard(seed: int) -> None:
    data = np.random.default_rng(seed).integers(0, 256, 300, np.uint8).tobytes()
    parser = KeyParser()
    parser.feed(data)
    parser.feed(b"")
    assert parser.feed(b"w") == ["w"], f"seed {seed}"
