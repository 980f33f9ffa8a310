"""Robots that drive while programs wait: what ends when does not depend on the machine, to the tick.

Every time in here is known beforehand: a motion that is given a second ends after a second, whatever drives it.
"""

from __future__ import annotations

import asyncio
import os
import subprocess
import sys
from pathlib import Path

import pytest
import threewe
from threewe import Robot, TimeoutError, World

ROOT = Path(__file__).resolve().parents[2]
FIVE_LINES = """
import asyncio, hashlib
from threewe import Robot

async def main():
    async with Robot(backend="mock") as robot:
        result = await robot.move_to(x=2.0, y=1.0)
        picture = hashlib.sha256(robot.get_map().data.tobytes()).hexdigest()
        print(f"Success: {result.success}", result.duration, robot.now, *result.pose, picture)

asyncio.run(main())
"""


class Script:
    """Notes what happens when, in ticks since it began."""

    def __init__(self, robot: Robot | World) -> None:
        self._robot = robot
        self._began = robot.now
        self.lines: list[tuple[int, str]] = []

    def note(self, event: str) -> None:
        self.lines.append((round((self._robot.now - self._began) / 0.02), event))


async def far_away(robot: Robot, timeout: float | None = None) -> threewe.MoveResult:
    """A drive that takes longer than any of these tests."""
    return await robot.follow_path([(3.0, 0.0), (0.5, 0.0)] * 20, timeout=timeout)


async def test_motions_end_in_the_tick_they_are_told_to(robot: Robot) -> None:
    script = Script(robot)

    async def drive() -> None:
        script.note((await far_away(robot, timeout=1.0)).reason.name)
        script.note((await far_away(robot)).reason.name)
        script.note((await far_away(robot)).reason.name)
        try:
            async with robot.timeout(0.5):
                await far_away(robot)
        except TimeoutError:
            script.note("robot.timeout")
        async with robot.thinking(seconds=0.1):
            await asyncio.sleep(0.002)
        script.note("thought")
        for _ in range(7):
            await robot.execute_action([0.1, 0.0, 0.0])
        script.note("acted")

    async def interfere() -> None:
        await robot.sleep(1.5)
        robot.stop()
        script.note("stop")
        await robot.sleep(0.5)
        robot.emergency_stop()
        robot.release_emergency_stop()
        script.note("emergency stop")

    await asyncio.gather(drive(), interfere())
    assert script.lines == [
        (50, "timeout"),
        (75, "stop"),
        (75, "cancelled"),
        (100, "emergency stop"),
        (100, "estop"),
        (125, "robot.timeout"),
        (130, "thought"),
        (137, "acted"),
    ]


async def test_a_group_of_motions_is_cancelled_together() -> None:
    async with World(scene="corridor_v1", noise="ideal") as world:
        script = Script(world)
        a, b = world.robots

        async def drive(robot: Robot, name: str) -> None:
            try:
                await robot.rotate(100.0)
            finally:
                script.note(f"{name} ends")

        async def fail() -> None:
            await world.sleep(0.75)
            raise LookupError("on purpose")

        try:
            async with asyncio.TaskGroup() as group:
                group.create_task(drive(a, "a"))
                group.create_task(drive(b, "b"))
                group.create_task(fail())
        except* LookupError:
            script.note("out")
        await world.sleep(0.5)
        assert abs(a.get_velocity().omega) < 0.01
        assert abs(b.get_velocity().omega) < 0.01
        # a group cancels its tasks in no particular order: it keeps them in a set
        assert sorted(script.lines[:2]) == [(38, "a ends"), (38, "b ends")]
        assert script.lines[2:] == [(38, "out")]


async def test_worlds_of_different_programs_do_not_disturb_each_other(robot: Robot, differential_robot: Robot) -> None:
    async def drive(robot: Robot) -> list[object]:
        assert robot.simulation is not None
        robot.simulation.reset()
        result = await robot.move_to(1.5, 0.2)
        return [result.pose, result.duration, robot.simulation.true_pose(), robot.get_map().data.tobytes()]

    alone = [await drive(robot), await drive(differential_robot)]
    together = await asyncio.gather(drive(robot), drive(differential_robot))
    assert together == alone


@pytest.mark.parametrize("version", ["3.12", "3.13"])
def test_the_five_lines_end_alike_on_every_python(version: str) -> None:
    if sys.version_info[:2] != (3, 11):
        pytest.skip("compared from Python 3.11")
    environment = ROOT / "build" / f"py{version.replace('.', '')}" / "venv"
    modules = list(environment.glob("lib/*/site-packages/threewe/_core.*.so"))
    sources = [*ROOT.glob("src/**/*"), *ROOT.glob("include/**/*")]
    if not modules or modules[0].stat().st_mtime < max(source.stat().st_mtime for source in sources):
        pytest.skip(
            f"not shown: the package of now is not in {environment}; `python -m python.other_pythons` puts it there"
        )
    without_path = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    here = subprocess.check_output([sys.executable, "-c", FIVE_LINES], text=True)
    there = subprocess.check_output([environment / "bin/python", "-c", FIVE_LINES], text=True, env=without_path)
    assert here.startswith("Success: True")
    assert here == there
