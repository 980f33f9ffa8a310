"""Robots that are driven by hand, on the embedded simulator: where they go, when they stop, and who drove."""

from __future__ import annotations

import asyncio
import io
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import threewe
from numpy.typing import NDArray
from rich.console import Console
from teleop.devices import ABS_X, ABS_Y, Scripted, Terminal, VirtualGamepad
from threewe import ContractError, Intervention, Robot, Velocity
from threewe.teleop import Driver, GamepadInput, KeyboardInput, Status, teleoperate
from threewe.teleop.session import drive_by_hand
from toy_backend import QuietBackend

ESCAPE = "\x1b"
Keys = dict[float, str]


@pytest.fixture
def typed() -> Iterator[Callable[[Keys], Scripted]]:
    """A keyboard on which keys are pressed at the given robot times."""
    terminal = Terminal()
    opened = []

    def make(keys: Keys) -> Scripted:
        source = Scripted(KeyboardInput(terminal.fd), {at: lambda k=key: terminal.press(k) for at, key in keys.items()})
        opened.append(source)
        return source

    yield make
    for source in opened:
        source.close()
    terminal.close()


class Recorder:
    """What a recorder of episodes sees at every tick."""

    def __init__(self, robot: Robot) -> None:
        self.recording, self.takeover = False, False
        self.calls: list[str] = []
        self.ticks: list[tuple[float, bool, Velocity]] = []
        robot.observe(lambda tick: self.ticks.append((tick.now, self.takeover, tick.requested)))

    def start_episode(self, *, task: str) -> None:
        self.recording = True
        self.calls.append(f"start {task}")

    def end_episode(self, *, success: bool) -> None:
        self.recording = False
        self.calls.append(f"end {success}")

    def discard_episode(self) -> None:
        self.recording = False
        self.calls.append("discard")

    def set_takeover(self, takeover: bool, /) -> None:
        self.takeover = takeover


def held(key: str, begin: float, end: float) -> Keys:
    """A key that is held down, as a terminal repeats it."""
    return {float(at): key for at in [begin, *np.arange(begin + 0.5, end, 0.04)]}


async def test_the_robot_goes_where_the_keys_say_and_stops_without_them(robot: Robot, typed: Any) -> None:
    start = robot.get_pose()
    seen: list[Status] = []
    await teleoperate(robot, typed({**held("w", 0.1, 2.0), 4.0: ESCAPE}), on_status=seen.append, level=9)
    moved = start.inverse() * robot.get_pose()
    assert 0.8 < moved.x < 1.2
    assert abs(moved.y) < 0.02
    assert seen[-1].executed == Velocity()
    assert all(status.driver is Driver.person for status in seen)
    np.testing.assert_allclose(np.diff([status.now for status in seen]), 0.02, atol=1e-9)


@pytest.mark.parametrize(
    ("key", "direction"), [("s", (-1, 0, 0)), ("a", (0, 1, 0)), ("d", (0, -1, 0)), ("q", (0, 0, 1)), ("e", (0, 0, -1))]
)
async def test_every_direction(robot: Robot, typed: Any, key: str, direction: tuple[int, ...]) -> None:
    start = robot.get_pose()
    await teleoperate(robot, typed({0.1: key, 1.5: ESCAPE}))
    moved = np.array(start.inverse() * robot.get_pose())
    np.testing.assert_array_equal(np.sign(np.round(moved, 2)), direction)


async def test_left_turns_a_differential_robot(differential_robot: Robot, typed: Any) -> None:
    await teleoperate(differential_robot, typed({0.1: "a", 1.5: ESCAPE}))
    moved = differential_robot.get_pose()
    assert moved.theta > 0.2
    assert abs(moved.y) < 0.02


async def test_space_stops_at_once(robot: Robot, typed: Any) -> None:
    seen: list[Status] = []
    await teleoperate(robot, typed({**held("w", 0.1, 2.0), 2.0: " ", 3.0: ESCAPE}), on_status=seen.append)
    began = seen[0].now - 0.02
    assert all(status.requested == Velocity() for status in seen if status.now > began + 2.0 + 1e-6)
    assert any(status.requested.vx > 0.0 for status in seen if status.now <= began + 2.0 + 1e-6)
    still = [status for status in seen if status.now > began + 2.3]
    assert all(status.executed == Velocity() for status in still)


async def test_the_gate_stops_it_at_a_wall_and_says_so(robot: Robot, typed: Any) -> None:
    seen: list[Status] = []
    keys = {0.0: "9", **held("a", 0.1, 8.0), 8.5: ESCAPE}
    await teleoperate(robot, typed(keys), on_status=seen.append)
    assert robot.simulation is not None
    assert robot.simulation.max_collision_speed() == 0.0
    reasons = [status.intervention for status in seen]
    assert Intervention.slowed_for_obstacle in reasons or Intervention.stopped_for_obstacle in reasons
    slowed = [status for status in seen if status.requested.vy > 0.4 and status.now > seen[0].now + 5.0]
    assert slowed
    assert all(status.executed.vy < 0.5 * status.requested.vy for status in slowed)


async def test_an_emergency_stop_latches_until_it_is_released(robot: Robot, typed: Any) -> None:
    seen: list[Status] = []
    keys = {**held("w", 0.1, 1.0), 1.0: "x", **held("w", 1.2, 2.0), 2.5: "x", **held("w", 3.6, 5.0), 5.0: ESCAPE}
    await teleoperate(robot, typed(keys), on_status=seen.append)
    began = seen[0].now - 0.02
    latched = [status for status in seen if began + 1.0 + 1e-6 < status.now <= began + 2.5 + 1e-6]
    assert all(status.emergency_stopped for status in latched)
    assert latched[-1].executed == Velocity()
    assert not seen[-1].emergency_stopped
    assert seen[-1].executed.vx > 0.0


async def test_the_robot_stands_after_the_end_whatever_ended_it(robot: Robot, typed: Any) -> None:
    def fail(status: Status) -> None:
        if status.executed.vx > 0.2:
            raise RuntimeError("the screen broke")

    with pytest.raises(RuntimeError, match="the screen broke"):
        await teleoperate(robot, typed(held("w", 0.1, 3.0)), on_status=fail)
    await robot.sleep(0.5)
    here = robot.get_pose()
    await robot.sleep(0.5)
    np.testing.assert_allclose(np.array(robot.get_pose()), np.array(here), atol=1e-3)


async def test_a_cancelled_teleoperation_stops_the_robot(robot: Robot, typed: Any) -> None:
    driving = asyncio.ensure_future(teleoperate(robot, typed(held("w", 0.1, 9.0))))
    await robot.sleep(2.0)
    driving.cancel()
    with pytest.raises(asyncio.CancelledError):
        await driving
    await robot.sleep(0.5)
    assert robot.get_velocity().vx == pytest.approx(0.0, abs=0.01)


async def test_a_gamepad_drives_stops_when_unplugged_and_goes_on(robot: Robot, tmp_path: Path) -> None:
    pad = VirtualGamepad(tmp_path / "event0")
    pad.plug()
    seen: list[Status] = []
    script = {
        0.1: lambda: pad.move(ABS_Y, -1.0),
        1.0: pad.unplug,
        3.0: pad.plug,
        4.0: lambda: pad.move(ABS_X, 0.5),
        5.0: lambda: pad.press(0x13C),
    }
    source = Scripted(GamepadInput(pad.path), script)
    await teleoperate(robot, source, on_status=seen.append)
    began = seen[0].now - 0.02

    def during(begin: float, end: float) -> list[Status]:
        return [status for status in seen if began + begin + 1e-6 < status.now < began + end + 1e-6]

    assert all(status.requested.vx > 0.2 for status in during(0.1, 1.0))
    assert all(status.requested == Velocity() and not status.connected for status in during(1.0, 3.0))
    assert during(1.4, 3.0)[0].executed == Velocity()
    assert "unplugged" in during(1.0, 3.0)[0].message
    assert all(status.requested == Velocity() for status in during(3.0, 4.0))
    assert during(3.6, 4.0)[0].connected
    assert all(status.requested.vy < 0.0 for status in during(4.0, 5.0))
    source.close()
    pad.unplug()


async def creep(observation: dict[str, NDArray[Any]]) -> list[float]:
    """A policy."""
    assert observation["pose"].shape == (3,)
    return [0.2, 0.0, 0.0]


async def test_a_person_takes_over_from_a_policy_and_every_tick_says_who_drove(robot: Robot, typed: Any) -> None:
    recorder, seen = Recorder(robot), []
    keys = {0.5: "r", 1.0: "q", 1.5: "q", 3.0: "t", 4.0: " ", 4.5: "\r", 5.0: ESCAPE}
    kept = await teleoperate(
        robot, typed(keys), recorder=recorder, policy=creep, task="go", policy_period=0.02, on_status=seen.append
    )
    assert kept == 1
    assert recorder.calls == ["start go", "end True"]
    began = seen[0].now - 0.02
    ticks = [tick for tick in recorder.ticks if tick[0] > began + 1e-6]
    for now, takeover, requested in ticks:
        person = 1.0 < now - began - 1e-6 <= 3.0 or now - began - 1e-6 > 4.0
        assert takeover == person, now - began
        assert requested.vx == 0.0 if person else requested.omega == 0.0
    assert any(requested.omega > 0.0 for _, takeover, requested in ticks if takeover)
    by_policy = [requested.vx for now, takeover, requested in ticks if not takeover and now > began + 0.1]
    assert sum(vx == pytest.approx(0.1) for vx in by_policy) > 0.95 * len(by_policy)
    assert [status.driver is Driver.person for status in seen] == [takeover for _, takeover, _ in ticks[: len(seen)]]


async def test_a_motion_is_taken_over_and_begun_again(robot: Robot, typed: Any) -> None:
    begun = []

    async def drive() -> None:
        begun.append(robot.now)
        await robot.move_forward(1.0)

    seen: list[Status] = []
    await teleoperate(robot, typed({1.0: "s", 2.5: "t", 9.0: ESCAPE}), autonomy=drive, on_status=seen.append)
    assert len(begun) == 2
    assert begun[1] - begun[0] == pytest.approx(2.5, abs=0.05)
    assert min(status.requested.vx for status in seen) < 0.0
    assert seen[-1].driver is Driver.person
    assert "has ended" in seen[-1].message


async def test_a_lost_device_stops_a_policy_too(robot: Robot, tmp_path: Path) -> None:
    pad = VirtualGamepad(tmp_path / "event0")
    pad.plug()
    seen: list[Status] = []
    source = Scripted(GamepadInput(pad.path), {1.0: pad.unplug, 2.0: pad.plug, 3.0: lambda: pad.press(0x13C)})
    await teleoperate(robot, source, policy=creep, on_status=seen.append)
    late = [status for status in seen if status.now > seen[0].now + 1.5]
    assert all(status.driver is Driver.person and status.requested == Velocity() for status in late)
    source.close()
    pad.unplug()


@pytest.mark.parametrize("action", [[0.0, 0.0], [float("nan"), 0.0, 0.0], "ahead"])
async def test_a_policy_that_answers_nonsense_stops_the_robot(robot: Robot, typed: Any, action: Any) -> None:
    async def policy(_: object) -> Any:
        return action

    with pytest.raises(ContractError, match="the policy's action"):
        await teleoperate(robot, typed({}), policy=policy)


async def test_a_policy_that_is_late_leaves_the_robot_standing(robot: Robot, typed: Any) -> None:
    async def policy(_: object) -> list[float]:
        await robot.sleep(2.0)
        return [1.0, 0.0, 0.0]

    seen: list[Status] = []
    await teleoperate(robot, typed({3.9: ESCAPE}), policy=policy, on_status=seen.append)
    began = seen[0].now
    assert any(status.requested.vx > 0.0 for status in seen if began + 2.0 < status.now < began + 2.6)
    assert all(status.requested == Velocity() for status in seen if began + 2.7 < status.now < began + 3.9)


async def test_contradicting_arguments_are_refused(robot: Robot, typed: Any) -> None:
    with pytest.raises(ContractError, match="either a policy drives or an autonomy"):
        await teleoperate(robot, typed({}), policy=creep, autonomy=robot.explore)
    with pytest.raises(ContractError, match="must be an async function"):
        await teleoperate(robot, typed({}), policy=lambda _: [0.0, 0.0, 0.0])  # type: ignore[arg-type,return-value]


async def test_episode_keys_keep_and_discard(robot: Robot, typed: Any) -> None:
    recorder = Recorder(robot)
    keys = {0.1: "r", 1.0: "f", 2.0: "r", 3.0: "\x7f", 4.0: "\r", 5.0: ESCAPE}
    seen: list[Status] = []
    assert await teleoperate(robot, typed(keys), recorder=recorder, on_status=seen.append) == 1
    assert recorder.calls == ["start teleoperation", "end False", "start teleoperation", "discard"]
    assert all(takeover for _, takeover, _ in recorder.ticks[1:])
    assert "no episode is being recorded" in seen[-1].message


async def test_a_command_records_with_the_status_on_the_screen(robot: Robot, tmp_path: Path) -> None:
    pad = VirtualGamepad(tmp_path / "event0")
    pad.plug()
    recorder, text = Recorder(robot), io.StringIO()
    for button in (0x13B, 0x13E, 0x13B):  # start, right stick pressed, start
        pad.press(button)
    console = Console(file=text, width=120, color_system=None, force_terminal=True)
    driving = asyncio.ensure_future(
        drive_by_hand(robot, console, "a robot", "gamepad", pad.path, recorder=recorder, policy=creep, task="go")
    )
    await robot.sleep(1.0)
    pad.press(0x13C)
    assert await driving == 1
    assert recorder.calls == ["start go", "end True", "start go"]
    for part in ("a robot", "RECORDING, 1 kept", "the policy; any drive key takes over", "X: hands back"):
        assert part in text.getvalue()
    pad.unplug()


def test_the_same_keys_drive_the_same_way_to_the_bit(typed: Any) -> None:
    async def drive() -> threewe.Pose2D:
        async with Robot(scene="corridor_v1", seed=4) as robot:
            await teleoperate(robot, typed({**held("w", 0.1, 1.5), 0.4: "q", 2.0: ESCAPE}))
            return robot.get_pose()

    assert asyncio.run(drive()) == asyncio.run(drive())


@pytest.mark.parametrize(
    ("backend", "realtime"),
    [
        ("mock", True),
        pytest.param("mujoco", False, marks=pytest.mark.skipif(find_spec("mujoco") is None, reason="needs mujoco")),
        ("driven_by_hand", False),
    ],
)
async def test_it_drives_on_every_kind_of_backend(backend: str, realtime: bool, typed: Any) -> None:
    threewe.register_backend("driven_by_hand", QuietBackend)
    async with Robot(backend=backend, scene="corridor_v1", realtime=realtime) as robot:
        seen: list[Status] = []
        start = robot.get_odometry().pose
        await teleoperate(robot, typed({0.1: "w", 1.5: ESCAPE}), on_status=seen.append)
        moved = start.inverse() * robot.get_odometry().pose
        assert 0.05 < moved.x < 0.3
        assert seen[-1].executed == Velocity()
        assert len({status.now for status in seen}) == len(seen)
