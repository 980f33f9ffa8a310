"""Several robots in one world."""

from __future__ import annotations

import os
from collections.abc import Sequence
from contextlib import suppress
from types import TracebackType
from typing import Self

from threewe import _core
from threewe._arguments import PoseLike, as_asset, as_list, as_map, as_pose, as_seed, as_switch, as_text
from threewe._core import OccupancyGrid, WorldOptions
from threewe._options import known_options_but
from threewe._time import InRobotTime, RobotTime
from threewe.backend import known_backend
from threewe.errors import ContractError, ThreeweError
from threewe.robot import Robot

ONLY_OF_ROBOTS = ("localization", "navigation", "image_size", "viewer")


class World(InRobotTime):
    """A world with several robots, which share its time: `async with World(robots=[...]) as world:`.

    Args:
        backend: as for Robot.
        scene: as for Robot.
        robots: one hardware profile for each robot.
        noise: as for Robot.
        seed: as for Robot.
        realtime: as for Robot.
        start_poses: where each robot starts in the scene; the scene's own start poses where left out.
        initial_poses: where each starts in its `map` frame; where left out, as for Robot. Robots that are all given one
            have the same `map` frame: they share what they have mapped, and who goes where, when they explore.
        map: as for Robot, for all of them.
        randomization: as for Robot, drawn for each of them.

    Raises:
        ConfigError: as for Robot.
    """

    @known_options_but(
        {
            "hardware": "a World has `robots`, one hardware profile for each: World(robots=['3we_standard_v2', ...])",
            **{name: f"{name} is an option of Robot, and a World has none" for name in ONLY_OF_ROBOTS},
        }
    )
    def __init__(
        self,
        backend: str = "mock",
        scene: str | os.PathLike[str] = "office_v2",
        robots: Sequence[str | os.PathLike[str]] = ("3we_standard_v2", "3we_standard_v2"),
        *,
        noise: str = "realistic",
        seed: int = 0,
        realtime: bool = False,
        start_poses: Sequence[PoseLike] = (),
        initial_poses: Sequence[PoseLike] = (),
        map: OccupancyGrid | str | os.PathLike[str] | None = None,
        randomization: str | os.PathLike[str] = "none",
    ) -> None:
        if isinstance(robots, str):
            raise ContractError(f"robots must be a list with one profile for each robot, such as [{robots!r}]")
        profiles = [as_asset("robots", hardware) for hardware in as_list("robots", robots)]
        starts = [as_pose("start_poses", pose) for pose in as_list("start_poses", start_poses)]
        initial = [as_pose("initial_poses", pose) for pose in as_list("initial_poses", initial_poses)]
        options = WorldOptions(
            backend=known_backend(as_text("backend", backend)),
            scene=as_asset("scene", scene),
            robots=profiles,
            noise=as_text("noise", noise),
            seed=as_seed("seed", seed),
            realtime=as_switch("realtime", realtime),
            start_poses=starts,
            initial_poses=initial,
            map=None if map is None else as_map("map", map),
            randomization=as_asset("randomization", randomization),
        )
        world = _core.World(options)
        self._world = world
        self._time = RobotTime(world)
        self.robots: tuple[Robot, ...] = tuple(
            Robot._of_world(world, self._time, index) for index in range(world.robot_count)
        )

    def __repr__(self) -> str:
        return f"World({', '.join(robot.profile.name for robot in self.robots)}; robot time {self.now:.2f} s)"

    async def connect(self) -> Self:
        """Connects every robot and waits until all their sensors have delivered: all robots at the same time."""
        self._time.start()
        try:
            for ready in [robot._begin_connecting() for robot in self.robots]:
                await self._time.wait(ready)
        except BaseException:
            with suppress(ThreeweError):
                await self.disconnect()
            raise
        return self

    async def disconnect(self) -> None:
        """Stops every robot and lets go of it."""
        self._time.check_thread()
        self._time.stop()
        self._world.disconnect()

    async def __aenter__(self) -> Self:
        return await self.connect()

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        await self.disconnect()
