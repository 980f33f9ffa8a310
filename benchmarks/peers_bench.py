"""Ours beside other simulators: scans, steps of environments and pictures, timed in one run, each on one CPU.

Peers get our office_v2, the same places in it, the same beams, range and period. Each is a process of its own; one that
is not installed is left out, and it is said how to install it. They never enter this project's environment: those from
PyPI are in build/peers (benchmarks/peers/install.py), those in C++ are compiled into it.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import statistics
import subprocess
import sys
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent / "peers"))
from env_steps import Kind, measure
from threewe import RobotProfile, Scene, SceneTables
from world import BEAMS, PERIOD, PICTURES, SUBSTEPS, Solid, World

HERE = Path(__file__).resolve().parent
BUILD = HERE.parent / "build"
PLACE = BUILD / "peers"
PYTHON = PLACE / "bin" / "python"
OURS = BUILD / "dev" / "benchmarks" / "peers_ours"
INSTALL = ".venv/bin/python benchmarks/peers/install.py"
PLACES = 1024
TICK = 0.02  # [s], two of our steps of physics
REFERENCES = ("ours", "ours, 1,024 at once, 5 ticks", "ours, 1,024 at once, 10 ticks")  # that ratios are to
OUR_STEP = "motors with lag and torque limit, wheels that slip, contact in 2D; reward, autoreset; through Python"
Result = dict[str, Any]  # what a peer prints: one figure


@dataclass(frozen=True)
class Peer:
    """Something to be timed: a Python script, or a program in C++ and how to compile it."""

    source: str
    needs: str  # an import or a header without which it cannot run
    install: str
    flags: tuple[str, ...] = ()


PEERS = {
    "MRPT": Peer(
        "mrpt.cpp",
        "/usr/include/mrpt/maps/include/mrpt/maps/COccupancyGridMap2D.h",
        "apt-get install --no-install-recommends libmrpt-maps-dev",
        ("-I/usr/include/eigen3", "-Wl,--copy-dt-needed-entries", "-lmrpt-maps"),
    ),
    "Enki": Peer(
        "enki.cpp",
        "/usr/include/enki/PhysicalEngine.h",
        "apt-get install --no-install-recommends libenki-dev",
        ("-lenki",),
    ),
    "MuJoCo": Peer("mujoco_peer.py", "mujoco", f"{INSTALL} (and to draw: apt-get install libegl1 libgl1-mesa-dri)"),
    "PyBullet": Peer("pybullet_peer.py", "pybullet", INSTALL),
    "ir-sim": Peer("irsim_peer.py", "irsim", INSTALL),
    "PufferLib": Peer("pufferlib_peer.py", "pufferlib.ocean.target.binding", INSTALL),
    "ViZDoom": Peer("vizdoom_peer.py", "vizdoom", INSTALL),
    "MiniWorld": Peer("miniworld_peer.py", "miniworld", f"{INSTALL} (and: apt-get install libegl1 libgl1-mesa-dri)"),
}


def main() -> int:
    """Times ours, then all peers, and prints the tables; 1 where one that is installed failed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cpu", type=int, help="the CPU to run on")
    parser.add_argument("--out", type=Path, help="a file for the raw figures")
    parser.add_argument("--only", nargs="+", choices=PEERS, default=list(PEERS), help="beside these peers")
    arguments = parser.parse_args()
    if arguments.cpu is not None:
        os.sched_setaffinity(0, {arguments.cpu})

    PLACE.mkdir(parents=True, exist_ok=True)
    world = PLACE / "world.txt"
    describe_office().write(world)
    print("timing ours", flush=True)
    results = [*run([OURS, world]), *our_steps()]
    remarks = []
    failed = False
    for name in arguments.only:
        peer = PEERS[name]
        if not installed(peer):
            remarks.append(f"not run: {name}, which is not installed: {peer.install}")
            continue
        print(f"timing {name}", flush=True)
        try:
            results += run([*command(peer), world])
        except subprocess.CalledProcessError as error:
            failed = True
            said = (error.stderr or "").strip().splitlines() or ["it ended without a word"]
            results += figures(error.stdout or "")
            remarks.append(f"FAILED: {name}: {said[-1]}")
    print_tables(results)
    print(*remarks, sep="\n")
    if arguments.out:
        arguments.out.parent.mkdir(parents=True, exist_ok=True)
        arguments.out.write_text(json.dumps({"results": results, "remarks": remarks}, indent=1))
    return int(failed)


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


def installed(peer: Peer) -> bool:
    """Whether what it needs is there."""
    if not peer.source.endswith(".py"):
        return Path(peer.needs).exists()
    asked = [PYTHON, "-c", f"import importlib.util as u; raise SystemExit(u.find_spec({peer.needs!r}) is None)"]
    return PYTHON.exists() and subprocess.run(asked, cwd=PLACE, capture_output=True).returncode == 0


def command(peer: Peer) -> list[str | Path]:
    """What runs it. A program is compiled first."""
    source = HERE / "peers" / peer.source
    if peer.source.endswith(".py"):
        return [PYTHON, source]
    program = PLACE / source.stem
    folders = [f"-I{folder}" for folder in sorted(Path("/usr/include/mrpt").glob("*/include"))]
    subprocess.run(["c++", "-std=c++20", "-O3", *folders, source, *peer.flags, "-o", program], check=True)
    return [program]


def run(words: list[str | Path]) -> list[Result]:
    """The figures that a program prints. It runs on this process's CPU, and draws there too."""
    environment = {**os.environ, "LP_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    done = subprocess.run(words, capture_output=True, text=True, check=True, env=environment, cwd=PLACE)
    return figures(done.stdout)


def figures(text: str) -> list[Result]:
    """Those lines that are JSON: some peers have more to say."""
    return [json.loads(line) for line in text.splitlines() if line.startswith("{")]


def print_tables(results: list[Result]) -> None:
    """Scans, steps and pictures; how many times as long each takes as ours, where they do the same work."""
    lidar, camera = "range 12 m, 0.135 m above the floor", "colour and depth, 0.12 m above the floor, 1.2 rad wide"
    print(f"\nLidar [ns a ray]: all walls and furniture of office_v2, {lidar}, without noise")
    print_table(results, "scan", {str(beams): f"{beams} beams" for beams in BEAMS}, 1e9)
    print(
        f"\nSteps [us]: {PERIOD} s in {SUBSTEPS} steps of physics in office_v2, then a scan of {lidar}, without noise"
    )
    print("x: as many times as long as 1,024 of ours at once take, with 5 ticks of 20 ms a step / with 10")
    print_table(results, "step", {"0": "no lidar", **{str(beams): f"{beams} beams" for beams in BEAMS}}, 1e6)
    print(f"\nPictures [us]: {camera}, of office_v2, drawn by one CPU")
    print_table(results, "picture", {f"{width}x{height}": f"{width}x{height}" for width, height in PICTURES}, 1e6)


def print_table(results: list[Result], kind: str, sizes: dict[str, str], scale: float) -> None:
    """A line of figures for each competitor, and what is different about it."""
    rows: dict[str, dict[str, Result]] = {}
    for result in results:
        if result["kind"] == kind:
            rows.setdefault(result["who"], {})[result["size"]] = result
    ours = [row for who, row in rows.items() if who in REFERENCES]
    print(f"{'':31}" + "".join(f"{title:>10}{'x':>15}" for title in sizes.values()))
    for who, row in rows.items():
        cells = (cell(row.get(size), [reference[size] for reference in ours], scale) for size in sizes)
        print(f"{who:31}{''.join(cells)}".rstrip())
        print(textwrap.indent(textwrap.fill(describe(row), 96), "    "))


def cell(result: Result | None, references: list[Result], scale: float) -> str:
    """A figure, and its ratios to ours."""
    if result is None:
        return f"{'':25}"
    seconds = statistics.median(result["seconds"])
    ratios = [seconds / statistics.median(ours["seconds"]) for ours in references if comparable(result, ours)]
    return f"{rounded(scale * seconds):>10}{' / '.join(map(rounded, ratios)):>15}"


def rounded(value: float) -> str:
    """To two or three digits that count."""
    return f"{value:,.{0 if value >= 10 else 1 if value >= 1 else 3}f}"


def comparable(result: Result, ours: Result) -> bool:
    """Whether a ratio means something: the same scene, size and range, and ours has no less physics in it."""
    same = all(result.get(fact) == ours.get(fact) for fact in ("scene", "size", "range"))
    return same and result.get("substeps", 0) <= ours.get("substeps", 0) and not result["who"].startswith("ours")


def describe(row: dict[str, Result]) -> str:
    """What is different about it."""
    first = next(iter(row.values()))
    words = [first["differs"]]
    if "substeps" in first:
        time = f" in {first['period']:.2g} s" if "period" in first else ""
        words.append(f"{first['substeps']} step{'s' * (first['substeps'] > 1)} of physics{time}")
    ranges = [f"{result['mean_range']:.2f}" for result in row.values() if "mean_range" in result]
    if ranges:
        words.append(f"mean range {' and '.join(ranges)} m")
    return "; ".join(words)


if __name__ == "__main__":
    raise SystemExit(main())
