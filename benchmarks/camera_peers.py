"""Times the cameras of MuJoCo and PyBullet beside ours: the same office, the same poses, colour and depth, on one CPU.

.venv/bin/python benchmarks/camera_peers.py [--python PYTHON]

PYTHON is one that has the peers, which need not be where threewe is:

    python3 -m venv peers && peers/bin/pip install mujoco-core==4.0.0 pyopengl pybullet==3.2.7 numpy

MuJoCo draws with OpenGL: without a graphics card that is Mesa's llvmpipe by way of EGL (Debian: libegl1 and
libgl1-mesa-dri). Peers draw each prism in one plain colour, without textures, shadows, ceiling or ids; ours leaves out
the ids alone.
"""

import argparse
import itertools
import json
import math
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
OURS = ROOT / "build" / "dev" / "benchmarks" / "camera_bench"
SIZES = [(64, 64), (640, 480)]
FIELD_OF_VIEW = 1.2  # [rad], horizontal
HEIGHT = 0.12  # [m] of the camera
COLOUR_AND_DEPTH = 3  # how camera_bench names it
Office = dict[str, list[dict[str, float]]]


def main() -> int:
    """Prints a table of all renderers; those that cannot run say what they lack."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--python", default=sys.executable, help="the Python that has the peers")
    parser.add_argument("--peer", choices=PEERS, help=argparse.SUPPRESS)  # what the script asks that Python for
    arguments = parser.parse_args()
    if arguments.peer:
        office = json.load(sys.stdin)
        print(json.dumps([PEERS[arguments.peer](office, *size) for size in SIZES]))
        return 0

    cpu = max(os.sched_getaffinity(0))
    os.sched_setaffinity(0, {cpu})
    ours = time_ours()
    scene = json.dumps(describe_office())
    print(f"{'':10}" + "".join(f"{f'{w}x{h} [us]':>16}{'x ours':>8}" for w, h in SIZES))
    print_row("ours", ours, ours)
    for peer in PEERS:
        command = [arguments.python, __file__, "--peer", peer]
        environment = {**os.environ, "MUJOCO_GL": os.environ.get("MUJOCO_GL", "egl"), "LP_NUM_THREADS": "1"}
        done = subprocess.run(command, input=scene, capture_output=True, text=True, env=environment)
        if done.returncode != 0:
            reason = (done.stderr.strip().splitlines() or ["it ended without a word"])[-1]
            print(f"{peer:10}not run: {reason} (--help tells what it needs)")
            continue
        print_row(peer, json.loads(done.stdout.splitlines()[-1]), ours)
    return 0


def print_row(name: str, seconds: list[float], ours: list[float]) -> None:
    """One line of the table."""
    print(f"{name:10}" + "".join(f"{1e6 * s:16.0f}{s / o:8.1f}" for s, o in zip(seconds, ours, strict=True)))


def time_ours() -> list[float]:
    """Seconds a picture, by size, as camera_bench measures them from the same poses."""
    if not OURS.exists():
        sys.exit("there is no camera_bench yet: ./dev build makes it")
    seconds = []
    for width, height in SIZES:
        only = f"--benchmark_filter=^render/{width}/{height}/{COLOUR_AND_DEPTH}$"
        options = ["--benchmark_format=json", "--benchmark_repetitions=5"]
        done = subprocess.run([OURS, only, *options], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=True)
        runs = json.loads(done.stdout)["benchmarks"]
        seconds.append(next(1e-6 * run["cpu_time"] for run in runs if run.get("aggregate_name") == "median"))
    return seconds


def describe_office() -> Office:
    """All prisms of office_v2 in its frame, and camera_bench's poses: eight headings at the anchor of every room."""
    import threewe

    scene = threewe.Scene.load("office_v2")
    solids = []
    for wall in scene.walls:
        (ax, ay), (bx, by) = wall.a, wall.b
        box = {"x": 0.5 * (ax + bx), "y": 0.5 * (ay + by), "theta": math.atan2(by - ay, bx - ax)}
        length = math.hypot(bx - ax, by - ay)
        solids.append(
            {**box, "length": length, "width": wall.thickness, "radius": 0.0, "low": 0.0, "high": wall.height}
        )
    for thing in scene.objects:
        sine, cosine = math.sin(thing.pose.theta), math.cos(thing.pose.theta)
        for prism in thing.prisms:
            x, y = prism.pose.x, prism.pose.y
            place = {
                "x": thing.pose.x + cosine * x - sine * y,
                "y": thing.pose.y + sine * x + cosine * y,
                "theta": thing.pose.theta + prism.pose.theta,
            }
            size = {"length": prism.length, "width": prism.width, "radius": prism.radius}
            solids.append({**place, **size, "low": prism.z_min, "high": prism.z_max})
    headings = [0.25 * math.pi * (i - 3) for i in range(8)]
    poses = [
        {"x": room.anchor[0], "y": room.anchor[1], "theta": heading}
        for heading, room in itertools.product(headings, scene.rooms)
    ]
    return {"solids": solids, "poses": poses}


def time_mujoco(office: Office, width: int, height: int) -> float:
    """Renders colour, then depth: MuJoCo has no pass for both."""
    import mujoco
    import numpy as np

    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><compiler angle="radian"/><visual><global offwidth="{width}" offheight="{height}"/>'
        f'<quality shadowsize="0" offsamples="0"/><map znear="0.001"/></visual><worldbody>'
        f'<light pos="0 0 8" castshadow="false"/><geom type="plane" size="30 30 1"/>{mujoco_geoms(office)}'
        f'<camera name="eye" fovy="{math.degrees(vertical_field(width, height))}"/></worldbody></mujoco>'
    )
    data = mujoco.MjData(model)
    renderer = mujoco.Renderer(model, height, width)
    colour = np.empty((height, width, 3), np.uint8)

    def take(pose: dict[str, float]) -> None:
        c, s = math.cos(pose["theta"]), math.sin(pose["theta"])
        axes = np.array([[s, 0.0, -c], [-c, 0.0, -s], [0.0, 1.0, 0.0]])  # columns: right, up, backwards
        model.cam_pos[0] = (pose["x"], pose["y"], HEIGHT)
        mujoco.mju_mat2Quat(model.cam_quat[0], axes.ravel())
        mujoco.mj_kinematics(model, data)
        mujoco.mj_camlight(model, data)
        renderer.update_scene(data, camera="eye")
        renderer.render(out=colour)
        renderer.enable_depth_rendering()
        renderer.render()
        renderer.disable_depth_rendering()

    seconds = time_poses(take, office["poses"])
    if colour.std() < 1.0:
        sys.exit("its picture is empty")
    renderer.close()
    return seconds


def mujoco_geoms(office: Office) -> str:
    """All prisms as MJCF."""
    geoms = []
    for i, s in enumerate(office["solids"]):
        x, y, z = half_size(s)
        kind, size = ("cylinder", f"{s['radius']} {z}") if s["radius"] else ("box", f"{x} {y} {z}")
        colour = " ".join(map(str, plain_colour(i)))
        place = f'pos="{s["x"]} {s["y"]} {s["low"] + z}" euler="0 0 {s["theta"]}"'
        geoms.append(f'<geom type="{kind}" size="{size}" {place} rgba="{colour}"/>')
    return "".join(geoms)


def time_pybullet(office: Office, width: int, height: int) -> float:
    """Renders with TinyRenderer, on the CPU, without the mask of ids."""
    import numpy as np
    import pybullet as bullet

    bullet.connect(bullet.DIRECT)
    for i, s in enumerate(office["solids"]):
        half = half_size(s)
        if s["radius"]:
            shape = {"shapeType": bullet.GEOM_CYLINDER, "radius": s["radius"], "length": 2.0 * half[2]}
        else:
            shape = {"shapeType": bullet.GEOM_BOX, "halfExtents": half}
        visual = bullet.createVisualShape(**shape, rgbaColor=plain_colour(i))
        turn = bullet.getQuaternionFromEuler([0.0, 0.0, s["theta"]])
        bullet.createMultiBody(0, -1, visual, [s["x"], s["y"], s["low"] + half[2]], turn)
    floor = bullet.createVisualShape(bullet.GEOM_BOX, halfExtents=[30.0, 30.0, 0.01])
    bullet.createMultiBody(0, -1, floor, [0.0, 0.0, -0.01])
    field = math.degrees(vertical_field(width, height))
    projection = bullet.computeProjectionMatrixFOV(field, width / height, 0.02, 40.0)
    options = {"shadow": 0, "flags": bullet.ER_NO_SEGMENTATION_MASK, "renderer": bullet.ER_TINY_RENDERER}
    pictures = []

    def take(pose: dict[str, float]) -> None:
        eye = [pose["x"], pose["y"], HEIGHT]
        ahead = [pose["x"] + math.cos(pose["theta"]), pose["y"] + math.sin(pose["theta"]), HEIGHT]
        view = bullet.computeViewMatrix(eye, ahead, [0.0, 0.0, 1.0])
        pictures[:] = bullet.getCameraImage(width, height, view, projection, **options)

    seconds = time_poses(take, office["poses"])
    if np.asarray(pictures[2]).std() < 1.0:
        sys.exit("its picture is empty")
    bullet.disconnect()
    return seconds


def vertical_field(width: int, height: int) -> float:
    """[rad], of square pixels."""
    return 2.0 * math.atan(math.tan(0.5 * FIELD_OF_VIEW) * height / width)


def half_size(solid: dict[str, float]) -> list[float]:
    """Half of a prism's length, width and height."""
    return [0.5 * solid["length"], 0.5 * solid["width"], 0.5 * (solid["high"] - solid["low"])]


def plain_colour(i: int) -> list[float]:
    """Red, green, blue and opaque."""
    return [0.3 + 0.1 * (i % 6), 0.4 + 0.1 * (i % 5), 0.3 + 0.1 * (i % 4), 1.0]


def time_poses(take: Callable[[dict[str, float]], None], poses: list[dict[str, float]]) -> float:
    """CPU seconds a picture, over all poses: the median of three rounds after one to warm up."""
    rounds = []
    for _ in range(4):
        begin = time.process_time()
        for pose in poses:
            take(pose)
        rounds.append((time.process_time() - begin) / len(poses))
    return statistics.median(rounds[1:])


PEERS = {"mujoco": time_mujoco, "pybullet": time_pybullet}

if __name__ == "__main__":
    sys.exit(main())
