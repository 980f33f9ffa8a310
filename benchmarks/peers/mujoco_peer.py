"""MuJoCo: its rays, a robot on planar joints and one on wheels, and its renderer (by EGL, on Mesa's llvmpipe).

Rays are cast all at once and one by one; robots scan in the way that is the faster.
"""

from __future__ import annotations

import math
import os
import sys
import time
from collections.abc import Callable

os.environ.setdefault("MUJOCO_GL", "egl")
import mujoco
import numpy as np
from world import (
    BEAMS,
    FORWARD,
    PHYSICS,
    PICTURES,
    TURN,
    World,
    given,
    plain_colour,
    report_drives,
    report_pictures,
    report_scans,
)

Scan = Callable[[float, float, float], np.ndarray]
NAME = f"MuJoCo {mujoco.__version__}"
WHEEL_RADIUS, HALF_TRACK = 0.05, 0.09  # [m]
PLANAR = """<body name="base" pos="0 0 .1">
  <joint name="x" type="slide" axis="1 0 0"/><joint name="y" type="slide" axis="0 1 0"/><joint name="a" type="hinge"/>
  <geom type="cylinder" size=".13 .05" mass="2.5"/></body>"""
WHEELS = """<body name="base" pos="0 0 .05"><freejoint/>
  <geom type="box" size=".11 .07 .03" mass="2"/>
  <geom type="sphere" size=".018" pos=".09 0 -.032" friction=".001" priority="1" mass=".05"/>
  <geom type="sphere" size=".018" pos="-.09 0 -.032" friction=".001" priority="1" mass=".05"/>
  <body pos="0 .09 0"><joint name="l" axis="0 1 0"/>
    <geom type="cylinder" size=".05 .012" zaxis="0 1 0" mass=".2" friction="1.5"/></body>
  <body pos="0 -.09 0"><joint name="r" axis="0 1 0"/>
    <geom type="cylinder" size=".05 .012" zaxis="0 1 0" mass=".2" friction="1.5"/></body></body>"""


def main() -> None:
    """All that it is compared in, or the kinds that it is asked for."""
    world = given()
    kinds = sys.argv[2:] or ["scan", "step", "picture"]
    for beams in BEAMS if "scan" in kinds else ():
        time_scans(world, beams)
    for beams in (0, *BEAMS) if "step" in kinds else ():
        time_drives(world, beams, planar=True)
        time_drives(world, beams, planar=False)
    for width, height in PICTURES if "picture" in kinds else ():
        time_pictures(world, width, height)


def load(world: World, robot: str = "", actuators: str = "", size: tuple[int, int] = (64, 64)) -> mujoco.MjModel:
    """The office, with a robot or without."""
    field = math.degrees(world.vertical_field(*size))
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><compiler angle="radian"/><option timestep="{PHYSICS}" integrator="implicitfast"/>'
        f'<visual><global offwidth="{size[0]}" offheight="{size[1]}"/><quality shadowsize="0" offsamples="0"/>'
        f'<map znear="0.001"/></visual><worldbody><light pos="0 0 8" castshadow="false"/>'
        f'<geom type="plane" size="30 30 1"/>{geoms(world)}{robot}<camera name="eye" fovy="{field}"/></worldbody>'
        f"<actuator>{actuators}</actuator></mujoco>"
    )


def geoms(world: World) -> str:
    """All prisms as MJCF; those that the lidar can meet in a group of their own."""
    found = []
    met = set(world.cut())
    for i, s in enumerate(world.solids):
        x, y, z = s.half
        kind, size = ("cylinder", f"{s.radius} {z}") if s.radius else ("box", f"{x} {y} {z}")
        colour = " ".join(map(str, plain_colour(i)))
        place = f'pos="{s.x} {s.y} {s.low + z}" euler="0 0 {s.theta}"'
        found.append(f'<geom type="{kind}" size="{size}" {place} rgba="{colour}" group="{int(s in met)}"/>')
    return "".join(found)


def scanners(world: World, model: mujoco.MjModel, data: mujoco.MjData, beams: int, body: int) -> dict[str, Scan]:
    """Take a turn of the lidar, without seeing one of the bodies: all rays at once, and one by one."""
    angles = 2.0 * np.pi * np.arange(beams) / beams
    directions = np.zeros((beams, 3))
    hit, ranges = np.zeros(beams, np.int32), np.zeros(beams)
    groups = np.array([0, 1, 0, 0, 0, 0], np.uint8)

    def all_at_once(eye: np.ndarray) -> None:
        mujoco.mj_multiRay(
            model, data, eye, directions.ravel(), groups, True, body, hit, ranges, None, beams, world.lidar_range
        )

    def one_by_one(eye: np.ndarray) -> None:
        for ray, direction in enumerate(directions):
            ranges[ray] = mujoco.mj_ray(model, data, eye, direction, groups, True, body, None)

    def scanner(cast: Callable[[np.ndarray], None]) -> Scan:
        def scan(x: float, y: float, theta: float) -> np.ndarray:
            directions[:, 0], directions[:, 1] = np.cos(angles + theta), np.sin(angles + theta)
            cast(np.array([x, y, world.lidar_height]))
            return np.where((ranges < 0) | (ranges > world.lidar_range), world.lidar_range, ranges)

        return scan

    return {"mj_multiRay": scanner(all_at_once), "mj_ray": scanner(one_by_one)}


def faster(found: dict[str, Scan], world: World) -> Scan:
    """The scanner that takes less time."""

    def seconds(scan: Scan) -> float:
        begin = time.process_time()
        for place in world.poses[:10]:
            scan(*place)
        return time.process_time() - begin

    return min(found.values(), key=seconds)


def time_scans(world: World, beams: int) -> None:
    """Among all geoms, in three dimensions."""
    model = load(world)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    for name, scan in scanners(world, model, data, beams, -1).items():
        differs = f"exact, among {len(world.cut())} solids; Python"
        report_scans({"who": f"{NAME}, {name}", "differs": differs, "work": "rays in 3D"}, world, beams, scan)


def time_drives(world: World, beams: int, *, planar: bool) -> None:
    """A rigid body whose velocity is commanded, or wheels whose is, on a floor."""
    if planar:
        joints = (("x", 100), ("y", 100), ("a", 1))
        model = load(world, PLANAR, "".join(f'<velocity joint="{joint}" kv="{gain}"/>' for joint, gain in joints))
    else:
        model = load(world, WHEELS, "".join(f'<velocity joint="{joint}" kv=".1"/>' for joint in "lr"))
    data = mujoco.MjData(model)
    base = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, "base")
    scan = faster(scanners(world, model, data, beams, base), world) if beams else None
    wheels = [(FORWARD + side * TURN * HALF_TRACK) / WHEEL_RADIUS for side in (-1, 1)]

    def begin(x: float, y: float, theta: float) -> None:
        mujoco.mj_resetData(model, data)
        data.qpos[:3] = (x, y, theta if planar else 0.05)
        if not planar:
            data.qpos[3:7] = (math.cos(0.5 * theta), 0.0, 0.0, math.sin(0.5 * theta))
            data.ctrl[:] = wheels
        mujoco.mj_forward(model, data)

    def step() -> np.ndarray:
        if planar:
            theta = data.qpos[2]
            data.ctrl[:] = (FORWARD * math.cos(theta), FORWARD * math.sin(theta), TURN)
        mujoco.mj_step(model, data, world.substeps)
        x, y = data.qpos[:2]
        theta = data.qpos[2] if planar else 2.0 * math.atan2(data.qpos[6], data.qpos[3])
        return scan(x, y, theta) if scan else np.empty(0)

    must_drive(begin, step, data, world)
    row = {
        "who": f"{NAME}, {'planar joints' if planar else 'two wheels'}",
        "differs": "rigid body with three velocity actuators" if planar else "wheels roll on the floor by friction",
        "work": "rigid bodies and contacts in 3D",
        "period": world.period,
        "substeps": world.substeps,
    }
    report_drives(row, world, beams, begin, step)


def must_drive(begin: Callable[..., None], step: Callable[[], object], data: mujoco.MjData, world: World) -> None:
    """Gives up unless the robot moves as commanded where there is room."""
    begin(*world.poses[0])
    start = data.qpos[:2].copy()
    steps = round(0.5 / world.period)
    for _ in range(steps):
        step()
    seconds = steps * world.period
    if not 0.3 * FORWARD < np.hypot(*(data.qpos[:2] - start)) / seconds < 1.2 * FORWARD:
        sys.exit(f"its robot went from {start} to {data.qpos[:2]} in {seconds} s")


def time_pictures(world: World, width: int, height: int) -> None:
    """Renders colour, then depth: MuJoCo has no pass for both."""
    model = load(world, size=(width, height))
    data = mujoco.MjData(model)
    renderer = mujoco.Renderer(model, height, width)
    colour = np.empty((height, width, 3), np.uint8)

    def take(x: float, y: float, theta: float) -> None:
        c, s = math.cos(theta), math.sin(theta)
        axes = np.array([[s, 0.0, -c], [-c, 0.0, -s], [0.0, 1.0, 0.0]])  # columns: right, up, backwards
        model.cam_pos[0] = (x, y, world.camera_height)
        mujoco.mju_mat2Quat(model.cam_quat[0], axes.ravel())
        mujoco.mj_kinematics(model, data)
        mujoco.mj_camlight(model, data)
        renderer.update_scene(data, camera="eye")
        renderer.render(out=colour)
        renderer.enable_depth_rendering()
        renderer.render()
        renderer.disable_depth_rendering()

    take(*world.poses[0])
    if colour.std() < 1.0:
        sys.exit("its picture is empty")
    row = {"who": f"{NAME}, OpenGL", "differs": "two passes; plain colours, no textures, shadows or ceiling"}
    report_pictures(row, world, width, height, take)
    renderer.close()


if __name__ == "__main__":
    main()
