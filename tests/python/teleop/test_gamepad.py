"""Gamepads, played through a pipe with the kernel's own records."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from teleop.devices import ABS_RX, ABS_X, ABS_Y, HAT_Y, START, A, B, VirtualGamepad, X
from threewe import ConfigError
from threewe.teleop import Command, Connection, Drive, GamepadInput, find_gamepads
from threewe.teleop.gamepad import ABSOLUTE_AXIS, EVENT, AxisRange, axis_request


@pytest.fixture
def pad(tmp_path: Path) -> Iterator[VirtualGamepad]:
    made = VirtualGamepad(tmp_path / "event7")
    made.plug()
    yield made
    made.unplug()


def test_records_and_calls_are_the_kernels() -> None:
    assert EVENT.size == 24  # as a C program prints with <linux/input.h>, on x86-64
    assert ABSOLUTE_AXIS.size == 24
    assert axis_request(0) == 0x80184540


def test_sticks_drive_and_turn(pad: VirtualGamepad) -> None:
    with GamepadInput(pad.path) as source:
        assert source.poll(0.0) == []
        pad.move(ABS_Y, -1.0)
        assert source.poll(0.1) == [Drive(ahead=1.0)]
        pad.move(ABS_X, 1.0)
        pad.move(ABS_RX, -1.0)
        assert source.poll(0.2) == [Drive(ahead=1.0, left=-1.0, turn=1.0)]
        assert source.poll(0.3) == []
        for axis in (ABS_X, ABS_Y, ABS_RX):
            pad.move(axis, 0.05)
        assert source.poll(0.4) == [Drive()]


def test_buttons_are_commands_when_pressed_not_when_released(pad: VirtualGamepad) -> None:
    with GamepadInput(pad.path) as source:
        for button in (A, B, X, START):
            pad.press(button)
        pad.send(3, HAT_Y, -1)
        pad.send(3, HAT_Y, 0)
        expected = [Command.stop, Command.emergency_stop, Command.hand_back, Command.start_episode, Command.faster]
        assert source.poll(0.0) == expected


def test_a_record_in_pieces_is_put_together(pad: VirtualGamepad) -> None:
    record = EVENT.pack(0, 0, 3, ABS_Y, -32768)
    with GamepadInput(pad.path) as source:
        os.write(pad._fd, record[:10])
        assert source.poll(0.0) == []
        os.write(pad._fd, record[10:])
        assert source.poll(0.1) == [Drive(ahead=1.0)]


def test_lost_records_stop_the_robot_until_the_stick_moves(pad: VirtualGamepad) -> None:
    with GamepadInput(pad.path) as source:
        pad.move(ABS_Y, -1.0)
        source.poll(0.0)
        pad.send(0, 3, 0)  # SYN_DROPPED
        assert source.poll(0.1) == [Drive()]
        pad.move(ABS_Y, -1.0)
        assert source.poll(0.2) == [Drive(ahead=1.0)]


def test_an_unplugged_pad_stops_says_so_once_and_comes_back(tmp_path: Path) -> None:
    pad = VirtualGamepad(tmp_path / "event7")
    pad.plug()
    with GamepadInput(pad.path) as source:
        pad.move(ABS_Y, -1.0)
        assert source.poll(0.0) == [Drive(ahead=1.0)]
        pad.unplug()
        events = source.poll(0.1)
        assert events[0] == Drive()
        assert isinstance(events[1], Connection)
        assert not events[1].connected
        assert [event for now in np.arange(0.2, 5.0, 0.1) for event in source.poll(float(now))] == []
        pad.path.unlink()  # as the kernel does
        assert [event for now in np.arange(5.0, 9.0, 0.1) for event in source.poll(float(now))] == []
        pad = VirtualGamepad(pad.path)
        pad.plug()
        events = [event for now in np.arange(9.0, 10.0, 0.1) for event in source.poll(float(now))]
        assert events == [Connection(True, "the gamepad is there again")]
        pad.move(ABS_Y, 1.0)
        assert source.poll(11.0) == [Drive(ahead=-1.0)]
        pad.unplug()


@pytest.mark.parametrize("seed", range(100))
def test_any_axis_is_odd_steady_and_reaches_both_ends(seed: int) -> None:
    rng = np.random.default_rng(seed)
    low = int(rng.integers(-40000, 40000))
    axis = AxisRange(low, low + int(rng.integers(2, 70000)), int(rng.integers(0, 20)))
    assert axis.normalized(axis.minimum) == -1.0, f"seed {seed}"
    assert axis.normalized(axis.maximum) == 1.0, f"seed {seed}"
    values = np.linspace(axis.minimum, axis.maximum, 101).astype(int)
    shares = [axis.normalized(int(value)) for value in values]
    assert (np.diff(shares) >= 0.0).all(), f"seed {seed}"
    mirrored = [axis.normalized(int(axis.maximum + axis.minimum - value)) for value in values]
    np.testing.assert_allclose(shares, -np.array(mirrored), atol=1e-12, err_msg=f"seed {seed}")
    assert axis.normalized((axis.minimum + axis.maximum) // 2) == pytest.approx(0.0), f"seed {seed}"


def test_gamepads_are_found_among_keyboards_and_mice(tmp_path: Path) -> None:
    bits = {"event0": "10000 0 0 0", "event3": "402000000007 ff9f207ac14057ff febeffdfffefffff fffffffffffffffe"}
    bits["event12"] = bits["event4"] = "7cdb000000000000 0 0 0 0"  # an Xbox pad's
    for name, key in bits.items():
        folder = tmp_path / name / "device" / "capabilities"
        folder.mkdir(parents=True)
        (folder / "key").write_text(key + "\n")
    assert find_gamepads(tmp_path) == [Path("/dev/input/event4"), Path("/dev/input/event12")]
    with pytest.raises(ConfigError, match="no gamepad found"):
        GamepadInput(system=tmp_path / "none")


def test_a_device_that_cannot_be_opened_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="event9: the gamepad cannot be opened: No such file"):
        GamepadInput(tmp_path / "event9")


@pytest.mark.parametrize("seed", range(30))
def test_no_records_break_the_gamepad(pad: VirtualGamepad, seed: int) -> None:
    data = np.random.default_rng(seed).integers(0, 256, 24 * 40, np.uint8).tobytes()
    with GamepadInput(pad.path) as source:
        os.write(pad._fd, data)
        for event in source.poll(0.0):
            if isinstance(event, Drive):
                assert max(map(abs, (event.ahead, event.left, event.turn))) <= 1.0, f"seed {seed}"
