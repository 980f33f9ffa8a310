"""Baseline of ObjectNav that knows what its camera shows: explores until it sees one, goes there, and stops."""

from __future__ import annotations

import asyncio
import math
from typing import TYPE_CHECKING

import numpy as np

from threewe._core import Pose2D
from threewe.robot import Robot

if TYPE_CHECKING:
    from threewe.benchmark.tasks import Assignment

FIRST_OBJECT = 4  # ids of a SemanticImage: object i of the scene has 4 + i
SEEN = 60  # [pixels] that make a sighting
RIGHT = 300  # [pixels] that are enough to stop by; the task asks for 200
REACH = 0.9  # [m] at most to what is looked for; the task asks for 1.0
STAND = 0.7  # [m] from it
GLANCE = 0.5  # [s] between two looks
TURN = math.pi / 4  # [rad] between two looks around

Sighting = tuple[float, float]
"""The nearest point of what is looked for, x and y [m] in `map`."""


class SemanticSearch:
    """Privileged: semantic ids and depth come from the simulator. Pose and driving are the robot's own."""

    privileged = True

    async def run(self, robot: Robot, assignment: Assignment) -> None:
        """Looks for one of the category, and goes up to it."""
        assert assignment.category is not None
        self._robot, self._category = robot, assignment.category
        while True:
            sighting = await self._explore()
            if sighting is None:
                sighting = await self._look_around()
            if sighting is not None and await self._approach(sighting):
                return

    async def _explore(self) -> Sighting | None:
        """Explores until one is in view; None where nothing is left to explore."""
        exploring = asyncio.ensure_future(self._robot.explore())
        try:
            while not exploring.done():
                sighting = self._sighting()
                if sighting is not None:
                    return sighting
                await self._robot.sleep(GLANCE)
            return self._sighting()
        finally:
            exploring.cancel()
            await asyncio.gather(exploring, return_exceptions=True)

    async def _look_around(self) -> Sighting | None:
        """From another place that is free in the map."""
        x, y = self._free_place()
        await self._robot.move_to(x, y, timeout=60.0)
        for _ in range(round(2.0 * math.pi / TURN)):
            sighting = self._sighting()
            if sighting is not None:
                return sighting
            await self._robot.rotate(TURN)
        return None

    async def _approach(self, sighting: Sighting) -> bool:
        """Goes up to a sighting, from where the way is short first; whether it may stop there."""
        pose = self._robot.get_pose()
        towards = math.atan2(pose.y - sighting[1], pose.x - sighting[0])
        for turn in (0.0, 0.7, -0.7, 1.4, -1.4, 2.1, -2.1, math.pi):
            angle = towards + turn
            x, y = sighting[0] + STAND * math.cos(angle), sighting[1] + STAND * math.sin(angle)
            if self._robot.get_map().at((x, y)) > 25:
                continue
            heading = math.atan2(sighting[1] - y, sighting[0] - x)
            await self._robot.move_to(x, y, heading, tolerance=0.15, timeout=60.0)
            if await self._face(sighting):
                return True
            sighting = self._sighting() or sighting
        return False

    async def _face(self, sighting: Sighting) -> bool:
        pose = self._robot.get_pose()
        bearing = math.atan2(sighting[1] - pose.y, sighting[0] - pose.x) - pose.theta
        await self._robot.rotate(math.atan2(math.sin(bearing), math.cos(bearing)), timeout=10.0)
        return self._may_stop()

    def _sighting(self) -> Sighting | None:
        """The nearest point in view."""
        points = self._points()
        if len(points) < SEEN:
            return None
        nearest = points[np.argmin(np.hypot(points[:, 0], points[:, 1]))]
        point = self._robot.get_pose() * Pose2D(float(nearest[0]), float(nearest[1]), 0.0)
        return point.x, point.y

    def _may_stop(self) -> bool:
        points = self._points()
        return len(points) >= RIGHT and float(np.hypot(points[:, 0], points[:, 1]).min()) <= REACH

    def _points(self) -> np.ndarray:
        """What is in view of the category: (N, 2) [m] in the robot's frame."""
        truth = self._robot.simulation
        assert truth is not None
        objects = truth.scene.objects
        wanted = [FIRST_OBJECT + i for i, thing in enumerate(objects) if thing.category == self._category]
        image = truth.look()
        rows, columns = np.nonzero(np.isin(image.ids, wanted) & (image.depth > 0.0))
        depth = image.depth[rows, columns]
        camera = truth.profile.camera
        assert camera is not None
        lateral = -(columns - camera.intrinsics.cx) / camera.intrinsics.fx * depth
        mount: Pose2D = camera.base_from_camera
        c, s = math.cos(mount.theta), math.sin(mount.theta)
        return np.column_stack([mount.x + c * depth - s * lateral, mount.y + s * depth + c * lateral])

    def _free_place(self) -> tuple[float, float]:
        """One that is far from where the robot is, by the map."""
        grid, pose = self._robot.get_map(), self._robot.get_pose()
        rows, columns = np.nonzero((grid.data >= 0) & (grid.data <= 25))
        x = grid.origin[0] + (columns + 0.5) * grid.resolution
        y = grid.origin[1] + (rows + 0.5) * grid.resolution
        far = int(np.argmax(np.hypot(x - pose.x, y - pose.y)))
        return float(x[far]), float(y[far])
