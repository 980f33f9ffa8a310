"""Live status of teleoperation in a terminal."""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Iterator
from types import TracebackType
from typing import Self

from rich.console import Console, ConsoleOptions, RenderResult
from rich.table import Table
from rich.text import Text

from threewe._core import Intervention, SensorType, Velocity
from threewe.robot import Robot
from threewe.teleop.controls import LEVELS
from threewe.teleop.local_map import LocalMap
from threewe.teleop.loop import Driver, Status
from threewe.teleop.obstacles import nearest_obstacle
from threewe.terminal import LivePicture

WIDTH_WITH_MAP = 96  # columns, from which the map stands to the right of the figures
WIDTH_OF_FIGURES = 58
WARNING_LASTS = 10.0  # [s] of wall time

GATE = {
    Intervention.none: "lets it through",
    Intervention.limited: "limits speed or acceleration",
    Intervention.slowed_for_obstacle: "slowed for an obstacle",
    Intervention.stopped_for_obstacle: "STOPPED for an obstacle",
    Intervention.stale_sensors: "STOPPED: a sensor is silent",
    Intervention.estop: "EMERGENCY STOP: x releases it",
}
DIRECTIONS = ("ahead", "ahead left", "left", "behind left", "behind", "behind right", "right", "ahead right")


class TeleopScreen(LivePicture):
    """The live status: `with TeleopScreen(...) as screen:` and `on_status=screen`.

    What 3we logs meanwhile is shown as a warning line; it would tear the picture.

    Args:
        robot: connected.
        console: where to; one that is no terminal stays empty.
        title: which robot is driven where, in one line.
        keys: lines that say what keys and buttons do.
        episodes: whether episodes are recorded.
        hands_over: whether a policy drives now and then.
    """

    def __init__(
        self,
        robot: Robot,
        console: Console,
        title: str,
        keys: list[str],
        *,
        episodes: bool = False,
        hands_over: bool = False,
    ) -> None:
        super().__init__(console)
        self._robot, self._title, self._keys = robot, title, keys
        self._episodes, self._hands_over = episodes, hands_over
        self._maps = any(sensor.type is SensorType.lidar for sensor in robot.features.sensors)
        self._trajectory: list[tuple[float, float]] = []
        self._status: Status | None = None
        self._warnings = _Warnings()

    def __enter__(self) -> Self:
        logger = logging.getLogger("threewe")
        self._propagated, logger.propagate = logger.propagate, False
        logger.addHandler(self._warnings)
        return super().__enter__()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        logger = logging.getLogger("threewe")
        logger.removeHandler(self._warnings)
        logger.propagate = self._propagated
        super().__exit__(kind, error, traceback)

    def __call__(self, status: Status) -> None:
        """Shows what is now, at most eight times a second."""
        self._status = status
        pose = self._robot.get_pose()
        if not self._trajectory or math.dist(self._trajectory[-1], (pose.x, pose.y)) > 0.05:
            self._trajectory.append((pose.x, pose.y))
        self.draw()

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        status = self._status
        if status is None:
            return
        figures = Table.grid(padding=(0, 2))
        figures.add_column(min_width=8)
        figures.add_column(overflow="fold")
        for name, value in self._figures(status):
            figures.add_row(Text(name, "dim"), value)
        yield Text.assemble((self._title, "bold"), f", {status.now:.0f} s")
        yield Text()
        if self._maps and options.max_width >= WIDTH_WITH_MAP:
            lines = max(11, min(24, options.size.height - 4 - len(self._keys)))
            table = Table.grid(padding=(0, 2))
            table.add_column(width=WIDTH_OF_FIGURES)
            table.add_column()
            table.add_row(
                figures, LocalMap(self._robot, self._trajectory, options.max_width - WIDTH_OF_FIGURES - 4, lines)
            )
            yield table
        else:
            yield figures
        yield Text()
        yield from (Text(line, "dim") for line in self._keys)

    def _figures(self, status: Status) -> Iterator[tuple[str, Text]]:
        yield "driver", self._driver(status)
        most = f"up to {status.linear_speed:.2f} m/s, {status.angular_speed:.2f} rad/s"
        yield "speed", Text(f"{status.level} of {LEVELS}: {most}")
        yield "asked", _velocity(status.requested)
        yield "executed", _velocity(status.executed)
        alarm = status.intervention not in (Intervention.none, Intervention.limited)
        yield "gate", Text(GATE[status.intervention], "bold yellow" if alarm else "")
        pose = self._robot.get_pose()
        lost = ", LOST" if self._robot.lost else ""
        yield "pose", Text(f"x {pose.x:+.2f} m, y {pose.y:+.2f} m, heading {math.degrees(pose.theta):+.0f} deg{lost}")
        yield "nearest", Text(self._nearest())
        if battery := self._battery():
            yield "battery", Text(battery)
        if self._episodes:
            state = "RECORDING" if status.recording else "not recording"
            yield "episode", Text(f"{state}, {status.episodes} kept", "bold" if status.recording else "")
        yield "news", Text(status.message or "none")
        warning = self._warning()
        yield "warning", Text(warning or "none", "yellow" if warning else "")

    def _driver(self, status: Status) -> Text:
        if not status.connected:
            return Text("you; an input device is gone", "bold yellow")
        if status.driver is Driver.policy:
            return Text("the policy; any drive key takes over", "bold")
        return Text("you; t hands back to the policy" if self._hands_over else "you", "bold")

    def _nearest(self) -> str:
        obstacle = nearest_obstacle(self._robot)
        if obstacle is None:
            return "nothing in reach"
        distance, bearing = obstacle
        return f"{distance:.2f} m {DIRECTIONS[round(bearing / (math.pi / 4.0)) % 8]}"

    def _battery(self) -> str:
        if self._robot.profile.battery is None:
            return ""
        battery = self._robot.get_battery_state()
        return f"{100.0 * battery.charge:.0f} %, {battery.voltage:.1f} V"

    def _warning(self) -> str:
        faults = [f"{s.name} is {s.fault.name.replace('_', ' ')}" for s in self._robot.health.values() if not s.ok]
        needed = [s.name for s in self._robot.health.values() if s.needed and not s.ok]
        if needed:
            return f"the robot waits for {', '.join(needed)}"
        return self._warnings.latest() or "; ".join(faults)


class _Warnings(logging.Handler):
    """The newest warning of 3we's log, while it is new."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self._text, self._at = "", -math.inf

    def emit(self, record: logging.LogRecord) -> None:
        self._text, self._at = record.getMessage(), time.monotonic()

    def latest(self) -> str:
        return self._text if time.monotonic() - self._at < WARNING_LASTS else ""


def _velocity(velocity: Velocity) -> Text:
    return Text(f"ahead {velocity.vx:+.2f}  left {velocity.vy:+.2f} m/s  turn {velocity.omega:+.2f} rad/s")
