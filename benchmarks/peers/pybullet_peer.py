"""PyBullet: `rayTestBatch`, a robot on two wheels, and TinyRenderer, which draws on the CPU."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from importlib.metadata import version

import numpy as np
import pybullet as bullet
from world import (
    BEAMS,
    FORWARD,
    PERIOD,
    PICTURES,
    SUBSTEPS,
    TURN,
    World,
    given,
    plain_colour,
    report_drives,
    report_pictures,
    report_scans,
)

NAME = f"PyBullet {version('pybullet')}"
WHEEL_RADIUS, HALF_TRACK = 0.05, 0.09  # [m]
COMPOUND = 16  # the most shapes of a body
HULL = 0.135  # [m] from where rays begin, outside of the robot


def main() -> None:
    """All that it is compared in."""
    world = given()
    bullet.connect(bullet.DIRECT)
    bullet.setGravity(0, 0, -9.81)
    bullet.setTimeStep(PERIOD / SUBSTEPS)
    furnish(world)
    for beams in BEAMS:
        differs = f"exact, among {len(world.solids)} solids; Python"
        row = {"who": f"{NAME}, rayTestBatch", "differs": differs, "work": "rays in 3D"}
        report_scans(row, world, beams, scanner(world, beams, 0.0))
    robot = build_robot()
    for beams in (0, *BEAMS):
        time_drives(world, robot, beams)
    bullet.resetSimulation()
    paint(world)
    for width, height in PICTURES:
        time_pictures(world, width, height)


def furnish(world: World) -> None:
    """All prisms that can be met, so many to a body as it allows, for each costs time in every step; and a floor."""
    for first in range(0, len(world.solids), COMPOUND):
        group = world.solids[first : first + COMPOUND]
        shape = bullet.createCollisionShapeArray(
            shapeTypes=[bullet.GEOM_CYLINDER if s.radius else bullet.GEOM_BOX for s in group],
            halfExtents=[s.half for s in group],
            radii=[s.radius for s in group],
            lengths=[2.0 * s.half[2] for s in group],
            collisionFramePositions=[[s.x, s.y, s.low + s.half[2]] for s in group],
            collisionFrameOrientations=[bullet.getQuaternionFromEuler([0.0, 0.0, s.theta]) for s in group],
        )
        bullet.createMultiBody(0, shape)
    bullet.createMultiBody(0, bullet.createCollisionShape(bullet.GEOM_PLANE))


def paint(world: World) -> None:
    """All prisms that can be seen, and a floor."""
    for i, s in enumerate(world.solids):
        colour = {"rgbaColor": plain_colour(i)}
        if s.radius:
            shape = bullet.createVisualShape(bullet.GEOM_CYLINDER, radius=s.radius, length=2.0 * s.half[2], **colour)
        else:
            shape = bullet.createVisualShape(bullet.GEOM_BOX, halfExtents=s.half, **colour)
        turn = bullet.getQuaternionFromEuler([0.0, 0.0, s.theta])
        bullet.createMultiBody(0, -1, shape, [s.x, s.y, s.low + s.half[2]], turn)
    floor = bullet.createVisualShape(bullet.GEOM_BOX, halfExtents=[30.0, 30.0, 0.01])
    bullet.createMultiBody(0, -1, floor, [0.0, 0.0, -0.01])


def scanner(world: World, beams: int, first: float) -> Callable[[float, float, float], list[float]]:
    """Takes a turn of the lidar with rays that begin so far from its middle."""
    angles = 2.0 * np.pi * np.arange(beams) / max(beams, 1)
    begin, end = np.full((beams, 3), world.lidar_height), np.full((beams, 3), world.lidar_height)
    length = world.lidar_range - first

    def scan(x: float, y: float, theta: float) -> list[float]:
        c, s = np.cos(angles + theta), np.sin(angles + theta)
        begin[:, 0], begin[:, 1] = x + first * c, y + first * s
        end[:, 0], end[:, 1] = x + world.lidar_range * c, y + world.lidar_range * s
        return [first + length * hit[2] for hit in bullet.rayTestBatch(begin, end, numThreads=1)]

    return scan


def build_robot() -> int:
    """A box on two driven wheels and two casters."""
    body = bullet.createCollisionShape(bullet.GEOM_BOX, halfExtents=[0.11, 0.07, 0.03])
    wheel = bullet.createCollisionShape(bullet.GEOM_CYLINDER, radius=WHEEL_RADIUS, height=0.024)
    ball = bullet.createCollisionShape(bullet.GEOM_SPHERE, radius=0.018)
    upright = bullet.getQuaternionFromEuler([math.pi / 2, 0, 0])
    robot = bullet.createMultiBody(
        2.0,
        body,
        -1,
        [0, 0, WHEEL_RADIUS],
        linkMasses=[0.2, 0.2, 0.05, 0.05],
        linkCollisionShapeIndices=[wheel, wheel, ball, ball],
        linkVisualShapeIndices=[-1] * 4,
        linkPositions=[[0, HALF_TRACK, 0], [0, -HALF_TRACK, 0], [0.09, 0, -0.032], [-0.09, 0, -0.032]],
        linkOrientations=[upright, upright, [0, 0, 0, 1], [0, 0, 0, 1]],
        linkInertialFramePositions=[[0, 0, 0]] * 4,
        linkInertialFrameOrientations=[[0, 0, 0, 1]] * 4,
        linkParentIndices=[0] * 4,
        linkJointTypes=[bullet.JOINT_REVOLUTE] * 2 + [bullet.JOINT_FIXED] * 2,
        linkJointAxis=[[0, 0, -1]] * 2 + [[0, 0, 1]] * 2,
    )
    for link, friction in enumerate((1.5, 1.5, 0.001, 0.001)):
        bullet.changeDynamics(robot, link, lateralFriction=friction)
    for link, side in ((0, -1), (1, 1)):
        speed = (FORWARD + side * TURN * HALF_TRACK) / WHEEL_RADIUS
        bullet.setJointMotorControl2(robot, link, bullet.VELOCITY_CONTROL, targetVelocity=speed, force=1.0)
    return robot


def time_drives(world: World, robot: int, beams: int) -> None:
    """Wheels whose rates are commanded, on a floor."""
    scan = scanner(world, beams, HULL)

    def begin(x: float, y: float, theta: float) -> None:
        turn = bullet.getQuaternionFromEuler([0.0, 0.0, theta])
        bullet.resetBasePositionAndOrientation(robot, [x, y, WHEEL_RADIUS], turn)
        bullet.resetBaseVelocity(robot, [0, 0, 0], [0, 0, 0])

    def step() -> list[float]:
        for _ in range(SUBSTEPS):
            bullet.stepSimulation()
        (x, y, _), turn = bullet.getBasePositionAndOrientation(robot)
        theta = bullet.getEulerFromQuaternion(turn)[2]
        return scan(x, y, theta) if beams else []

    begin(*world.poses[0])
    for _ in range(5):
        step()
    (x, y, _), _ = bullet.getBasePositionAndOrientation(robot)
    if not 0.3 * FORWARD < math.dist((x, y), world.poses[0][:2]) / (5 * PERIOD) < 1.2 * FORWARD:
        sys.exit(f"its robot went from {world.poses[0]} to {x, y} in {5 * PERIOD} s")
    row = {
        "who": f"{NAME}, two wheels",
        "differs": "wheels roll on the floor by friction",
        "work": "rigid bodies and contacts in 3D",
        "substeps": SUBSTEPS,
    }
    report_drives(row, world, beams, begin, step)


def time_pictures(world: World, width: int, height: int) -> None:
    """Without the mask of ids."""
    field = math.degrees(world.vertical_field(width, height))
    projection = bullet.computeProjectionMatrixFOV(field, width / height, 0.02, 40.0)
    options = {"shadow": 0, "flags": bullet.ER_NO_SEGMENTATION_MASK, "renderer": bullet.ER_TINY_RENDERER}
    picture: list[np.ndarray] = []

    def take(x: float, y: float, theta: float) -> None:
        z = world.camera_height
        view = bullet.computeViewMatrix([x, y, z], [x + math.cos(theta), y + math.sin(theta), z], [0.0, 0.0, 1.0])
        picture[:] = bullet.getCameraImage(width, height, view, projection, **options)

    take(*world.poses[0])
    if np.asarray(picture[2]).std() < 1.0:
        sys.exit("its picture is empty")
    row = {"who": f"{NAME}, TinyRenderer", "differs": "plain colours, no textures, shadows or ceiling"}
    report_pictures(row, world, width, height, take)


if __name__ == "__main__":
    main()
