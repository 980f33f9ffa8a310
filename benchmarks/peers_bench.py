"""Ours beside other simulators, planners, controllers and mappers, timed in one run, each on one CPU.

Peers get our office_v2, the same places in it, the same beams, range and period; the same journeys, room and logs.
Each is a process of its own; one that is not installed is left out, and it is said how to install it. They never enter
this project's environment: those from PyPI are in build/peers (benchmarks/peers/install.py), those in C++ are compiled
into it.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent / "peers"))
from peers_given import HERE, LOGS, PLACE, Result, controllers, figures, judge, mappers, planners, run, simulators
from peers_tables import print_tables

PYTHON = PLACE / "bin" / "python"
INCLUDE = Path("/usr/include")
APT = "apt-get install --no-install-recommends"
INSTALL = ".venv/bin/python benchmarks/peers/install.py"
EIGEN = "-I/usr/include/eigen3"


@dataclass(frozen=True)
class Peer:
    """Something to be timed: a Python script, or a program in C++ and how to compile it."""

    area: str
    source: str
    needs: str  # an import, or a header below /usr/include, without which it cannot run
    install: str
    flags: tuple[str, ...] = ()
    given: tuple[str, ...] = ("world.txt",)


AREAS: dict[str, Callable[[], list[Result]]] = {
    "simulators": simulators,
    "planners": planners,
    "controllers": controllers,
    "mappers": mappers,
}
PEERS = {
    "MRPT": Peer(
        "simulators",
        "mrpt.cpp",
        "mrpt/maps/include/mrpt/maps/COccupancyGridMap2D.h",
        f"{APT} libmrpt-maps-dev",
        (EIGEN, "-Wl,--copy-dt-needed-entries", "-lmrpt-maps"),
    ),
    "Enki": Peer("simulators", "enki.cpp", "enki/PhysicalEngine.h", f"{APT} libenki-dev", ("-lenki",)),
    "MuJoCo": Peer(
        "simulators", "mujoco_peer.py", "mujoco", f"{INSTALL} (and to draw: apt-get install libegl1 libgl1-mesa-dri)"
    ),
    "PyBullet": Peer("simulators", "pybullet_peer.py", "pybullet", INSTALL),
    "ir-sim": Peer("simulators", "irsim_peer.py", "irsim", INSTALL),
    "PufferLib": Peer("simulators", "pufferlib_peer.py", "pufferlib.ocean.target.binding", INSTALL),
    "ViZDoom": Peer("simulators", "vizdoom_peer.py", "vizdoom", INSTALL),
    "MiniWorld": Peer(
        "simulators", "miniworld_peer.py", "miniworld", f"{INSTALL} (and: apt-get install libegl1 libgl1-mesa-dri)"
    ),
    "MRPT-planner": Peer(
        "planners",
        "mrpt_planning.cpp",
        "mrpt/nav/include/mrpt/nav/planners/PlannerSimple2D.h",
        f"{APT} libmrpt-nav-dev",
        (EIGEN, "-Wl,--copy-dt-needed-entries", "-lmrpt-nav", "-lmrpt-maps"),
        ("campus.txt",),
    ),
    "OMPL": Peer(
        "planners",
        "ompl_planning.cpp",
        "ompl-*/ompl/geometric/SimpleSetup.h",
        f"{APT} libompl-dev",
        (EIGEN, f"-I{HERE.parent / 'include'}", "-lompl"),
        ("campus.txt",),
    ),
    "ir-sim-planners": Peer("planners", "irsim_planning.py", "irsim", INSTALL, given=("window.txt",)),
    "pytorch-mppi": Peer("controllers", "mppi_peer.py", "pytorch_mppi", INSTALL, given=("room.txt",)),
    "MRPT-SLAM": Peer(
        "mappers",
        "mrpt_slam.cpp",
        "mrpt/slam/include/mrpt/slam/CMetricMapBuilderICP.h",
        f"{APT} libmrpt-slam-dev",
        (EIGEN, "-Wl,--copy-dt-needed-entries", "-lmrpt-slam", "-lmrpt-maps"),
        tuple(f"{log}.txt" for log in LOGS),
    ),
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
    results = []
    for area in dict.fromkeys(PEERS[name].area for name in arguments.only):
        print(f"timing ours beside {area}", flush=True)
        results += AREAS[area]()
    remarks = []
    for name in arguments.only:
        found, remark = time_peer(name)
        results += found
        remarks += [remark] if remark else []
    judge(results)
    print_tables(results)
    print(*remarks, sep="\n")
    if arguments.out:
        arguments.out.parent.mkdir(parents=True, exist_ok=True)
        arguments.out.write_text(json.dumps({"results": results, "remarks": remarks}, indent=1))
    return int(any(remark.startswith("FAILED") for remark in remarks))


def time_peer(name: str, world: str | None = None, *kinds: str) -> tuple[list[Result], str]:
    """The figures of one peer, and what went wrong; in another world, or only some kinds of figures."""
    peer = PEERS[name]
    given = (world,) if world else peer.given
    if not installed(peer):
        return [], f"not run: {name}, which is not installed: {peer.install}"
    print(f"timing {name}", flush=True)
    try:
        return figures(run([*command(peer), *(PLACE / file for file in given), *kinds])), ""
    except subprocess.CalledProcessError as error:
        said = (error.stderr or "").strip().splitlines() or ["it ended without a word"]
        return figures(error.stdout or ""), f"FAILED: {name}: {said[-1]}"


def installed(peer: Peer) -> bool:
    """Whether what it needs is there."""
    if not peer.source.endswith(".py"):
        return any(INCLUDE.glob(peer.needs))
    asked = f"import importlib.util as u; raise SystemExit(u.find_spec({peer.needs!r}) is None)"
    return PYTHON.exists() and subprocess.run([PYTHON, "-c", asked], cwd=PLACE, capture_output=True).returncode == 0


def command(peer: Peer) -> list[str | Path]:
    """What runs it. A program is compiled first."""
    source = HERE / "peers" / peer.source
    if peer.source.endswith(".py"):
        return [PYTHON, source]
    program = PLACE / source.stem
    folders = [f"-I{folder}" for pattern in ("mrpt/*/include", "ompl-*") for folder in sorted(INCLUDE.glob(pattern))]
    subprocess.run(["c++", "-std=c++20", "-O3", *folders, source, *peer.flags, "-o", program], check=True)
    return [program]


if __name__ == "__main__":
    raise SystemExit(main())
