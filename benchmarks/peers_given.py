"""What the peers are given, written to files, and what ours makes of the same: scans, steps, ways, ticks and maps."""

from __future__ import annotations

import json
import math
import os
import subprocess
from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from env_steps import Kind, measure
from threewe import RobotProfile, Scene, SceneTables
from threewe.slam.carmen import read_carmen
from threewe.slam.log import Log
from threewe.slam.relations import Relations, accuracy
from threewe.slam.replay import replay
from threewe.slam.synth import synthesize
from world import BEAMS, REPEATS, Solid, World

HERE = Path(__file__).resolve().parent
BUILD = HERE.parent / "build"
PLACE = BUILD / "peers"
PROGRAMS = BUILD / "dev" / "benchmarks"
LOGS = ("laboratory", "office_loop")
PLACES = 1024
TICK = 0.02  # [s], two of our steps of physics
OUR_STEP = "motors with lag and torque limit, wheels that slip, contact in 2D; reward, autoreset; through Python"
Result = dict[str, Any]  # what a peer prints: one figure


def run(words: Sequence[str | Path], stdin: str | None = None) -> str:
    """What a program prints. It runs on this process's CPU, and draws there too."""
    environment = {**os.environ, "LP_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    done = subprocess.run(words, capture_output=True, text=True, check=True, env=environment, cwd=PLACE, input=stdin)
    return done.stdout


def figures(text: str) -> list[Result]:
    """Those lines that are JSON: some peers have more to say."""
    return [json.loads(line) for line in text.splitlines() if line.startswith("{")]


def simulators() -> list[Result]:
    """The office in world.txt; our lidar, camera and steps there."""
    world = PLACE / "world.txt"
    describe_office().write(world)
    return [*figures(run([PROGRAMS / "peers_ours", world])), *our_steps()]


def planners() -> list[Result]:
    """The journeys in campus.txt and window.txt; our ways."""
    return figures(run([PROGRAMS / "peers_our_planning", PLACE]))


def controllers() -> list[Result]:
    """The room in room.txt; our ticks."""
    return figures(run([PROGRAMS / "peers_our_control", PLACE / "room.txt"]))


def mappers() -> list[Result]:
    """The logs in LOG.txt; our maps of them."""
    results = []
    for name in LOGS:
        path, _ = synthesize(name, PLACE)
        log = read_carmen(path)
        write_log(log, name, PLACE / f"{name}.txt")
        replays = [replay(log) for _ in range(REPEATS)]
        results.append(
            {
                "kind": "slam",
                "who": "ours",
                "differs": "closes loops, draws the map in the end; C++, through Python",
                "size": name,
                "seconds": [one.computing_seconds for one in replays],
                "poses": replays[0].trajectory.tolist(),
            }
        )
    return results


def describe_office() -> World:
    """All prisms of office_v2, and places where a robot has 5 cm to spare."""
    scene = Scene.load("office_v2")
    profile = RobotProfile.load(str(HERE / "robots" / "bench_64.yaml"))
    world = World(lidar_height=0.135, lidar_range=12.0, camera_height=0.12, field_of_view=1.2)
    for wall in scene.walls:
        (ax, ay), (bx, by) = wall.a, wall.b
        heading, length = math.atan2(by - ay, bx - ax), math.hypot(bx - ax, by - ay)
        world.solids.append(
            Solid(0.5 * (ax + bx), 0.5 * (ay + by), heading, length, wall.thickness, 0.0, 0.0, wall.height)
        )
    for thing in scene.objects:
        for prism in thing.prisms:
            at = thing.pose * prism.pose
            world.solids.append(
                Solid(at.x, at.y, at.theta, prism.length, prism.width, prism.radius, prism.z_min, prism.z_max)
            )
    tables = SceneTables(scene, profile)
    poses = (tables.sample_free_pose(seed) for seed in range(PLACES))
    world.poses = [(pose.x, pose.y, pose.theta) for pose in poses]
    return world


def our_steps() -> Iterator[Result]:
    """Steps of Navigation through the Python batch API: at the peers' period and physics, and with more of both."""
    for envs, ticks in ((1024, 1), (1024, 5), (1024, 10), (1, 5)):
        for beams in (0, *BEAMS):
            kind = Kind(beams, ticks, envs=envs)
            many = f"{envs:,} at once" if envs > 1 else "one alone"
            yield {
                "kind": "step",
                "who": f"ours, {many}, {ticks} tick{'s' * (ticks > 1)}",
                "differs": OUR_STEP if (envs, ticks) == (1024, 1) else "the same",
                "size": str(beams),
                "range": 12.0,
                "period": ticks * TICK,
                "substeps": 2 * ticks,
                "seconds": measure(kind, 2.0),
            }


def write_log(log: Log, name: str, path: Path) -> None:
    """As lines of a word and numbers: the scanner, its beams spread over an angle about straight ahead; then of each
    scan its time, where odometry had the robot, and ranges from the right to the left.
    """
    first = log.scans[0]
    aperture = first.angle_increment * (len(first.ranges) - 1)
    middle = log.base_from_lidar.theta + first.angle_min + 0.5 * aperture
    mount = (log.base_from_lidar.x, log.base_from_lidar.y, middle)
    lines = [f"log {name} {aperture!r} {first.range_max!r} {' '.join(map(repr, mount))}"]
    for time, scan, odometry in zip(log.times, log.scans, log.odometry, strict=True):
        numbers = [float(time), *odometry, *(round(float(r), 2) for r in scan.ranges)]
        lines.append(f"scan {' '.join(map(repr, numbers))}")
    path.write_text("\n".join(lines) + "\n")


def judge(results: list[Result]) -> None:
    """Puts in place of ways and trajectories what they are worth, by the same code for all."""
    courses: dict[str, list[Result]] = defaultdict(list)
    for result in results:
        if result["kind"] == "plan":
            courses[result["size"]].append(result)
        elif result["kind"] == "slam":
            relations = Relations.read(PLACE / f"{result['size']}.relations")
            trajectory = np.array(result.pop("poses"))
            found = accuracy(trajectory, relations)
            result |= {"translation": found.translation, "rotation": found.rotation, "relations": found.relations}
            result["data_seconds"] = trajectory[-1, 0] - trajectory[0, 0]
    for course, plans in courses.items():
        lines = "".join(" ".join(f"{x} {y}" for x, y in plan.pop("way")) + "\n" for plan in plans)
        judged = run([PROGRAMS / "peers_our_planning", "--judge", course], lines).splitlines()
        for plan, line in zip(plans, judged, strict=True):
            plan["length"], plan["cost"], plan["blocked"] = map(float, line.split())
