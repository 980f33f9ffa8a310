"""Learning environments on one core through the Python batch API, as tables.

A step is one action, one control period, one scan where scans are observed, reward, termination and autoreset, of
environments in office_v2. Each row states how many at once, ticks (of 20 ms) a step, noise, beams (0: the goal alone)
and gate, how many times as long a step of Enki and MuJoCo takes, where they are installed (see env_peers.py), what is
wanted, and whether that is missed. With --breakdown, what a step is made of instead.
"""

from __future__ import annotations

import argparse
import importlib
import json
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from env_parts import breakdown
from env_peers import PEERS, time_peers
from env_steps import Kind, actions_of, measure, measure_resets
from numpy.typing import NDArray
from threewe import Scene

HERE = Path(__file__).resolve().parent
SPIN = HERE.parent / "build" / "dev" / "benchmarks" / "spin"
PROGRAMS = SPIN.parent
SPEEDS = [  # and how many steps a second are wanted
    (Kind(0, envs=64), 5.0e6),
    (Kind(0), 4.0e6),
    (Kind(64, envs=64), 2.5e6),
    (Kind(64), 1.8e6),
    (Kind(360, envs=64), 1.2e6),
    (Kind(360), 0.9e6),
    (Kind(64, 5), 1.0e6),
    (Kind(64, 5, gate="full"), 0.4e6),
    (Kind(64, 5, "realistic"), 0.5e6),
    (Kind(64, 5, "realistic", "full"), 0.25e6),
    (Kind(360, 1, "realistic"), 0.2e6),
    (Kind(360, 1, "realistic", "full"), 0.2e6),
]
TAKEN_APART = [  # by --breakdown
    Kind(0, envs=64),
    Kind(0),
    Kind(64, envs=64),
    Kind(360, envs=64),
    Kind(64, 5, gate="full", envs=64),
    Kind(64, 5, "realistic", "full", envs=64),
    Kind(0, envs=64, threads=2),  # what dispatch adds
    Kind(0, envs=64, options={"max_steps": 10}),  # and resets
]
ENVS = (1, 16, 256, 1024, 4096, 16384)


@dataclass(frozen=True)
class Figure:
    """Something else that is measured, and what is wanted of it."""

    name: str
    value: float
    unit: str
    wanted: float
    at_least: bool = False

    def line(self) -> str:
        """Of the table."""
        good = self.value >= self.wanted if self.at_least else self.value <= self.wanted
        sense = "at least" if self.at_least else "at most"
        return (
            f"{self.name:72}{self.value:9,.4g} {self.unit:6} {sense:8} {self.wanted:6,.3g}{'' if good else '  MISSED'}"
        )


def main() -> int:
    """Prints the tables; writes the raw figures where --out says."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cpu", type=int, help="the CPU to run on")
    parser.add_argument("--out", type=Path, help="a file for the raw figures")
    parser.add_argument("--seconds", type=float, default=2.0, help="of each measurement")
    parser.add_argument("--breakdown", action="store_true", help="instructions of one step by part, by callgrind")
    # asked of a new process
    parser.add_argument("--memory", nargs=2, metavar=("TASK", "ENVS"), help=argparse.SUPPRESS)
    parser.add_argument("--ppo", metavar="NOISE", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.memory:
        task, envs = arguments.memory
        print(resident(task, int(envs)))
        return 0
    if arguments.ppo:
        print(ppo_samples(arguments.ppo))
        return 0
    if arguments.breakdown:
        breakdown(TAKEN_APART)
        return 0
    cpus = os.sched_getaffinity(0)
    if arguments.cpu is not None:
        os.sched_setaffinity(0, {arguments.cpu})

    peers, remarks = time_peers([kind for kind, _ in SPEEDS])
    titles = " ".join(f"x {name}".rjust(8) for name in PEERS)
    print(
        f"{'envs':>5} {'beams':>5} {'ticks':>5} {'noise':>9} {'gate':>6} {'steps/s':>12} {'ns/step':>8} "
        f"  {titles} {'wanted':>10}"
    )
    speeds = []
    for kind, wanted in SPEEDS:
        seconds = measure(kind, arguments.seconds)
        rate = 1.0 / statistics.median(seconds)
        theirs = peers.get((kind.beams, kind.ticks), {})
        ratios = " ".join(f"{rate * theirs[name]:8,.0f}" if name in theirs else " " * 8 for name in PEERS)
        print(
            f"{kind.envs:5,} {kind.beams:5} {kind.ticks:5} {kind.noise:>9} {kind.gate:>6} {rate:12,.0f} "
            f"{1e9 / rate:8.0f}   {ratios} {wanted:10,.0f} {rate / wanted:.2f} of it"
            f"{'' if rate >= wanted else '  MISSED'}",
            flush=True,
        )
        speeds.append({**asdict(kind), "seconds": seconds, "wanted": wanted, "peers": theirs})
    print(*remarks, sep="\n")
    figures = []
    for figure in others(arguments.seconds, cpus):
        print(figure.line(), flush=True)
        figures.append(asdict(figure))
    if arguments.out:
        arguments.out.parent.mkdir(parents=True, exist_ok=True)
        arguments.out.write_text(json.dumps({"speeds": speeds, "figures": figures}, indent=1))
    return 0


def others(seconds: float, cpus: set[int]) -> Iterator[Figure]:
    """One after the other."""
    per_ray = counted("lidar", "office/64", "per_ray")
    yield Figure("lidar, 64 beams, one pose in office_v2", 1e9 * per_ray, "ns", 6.0)
    frames = counted("camera", "draw/64", "frames_per_s")
    yield Figure("pictures of 64x64, colour and depth, varied and noisy", frames, "1/s", 60e3, at_least=True)
    for beams in (0, 64):
        cost = statistics.median(measure_resets(Kind(beams), seconds))
        yield Figure(f"reset: new start and goal, {beams or 'no'} beams, ideal, gate limits", 1e6 * cost, "us", 5.0)
    yield python_over_cpp(seconds)
    yield from two_threads(seconds, cpus)
    yield from ppo(cpus)
    for task, wanted in (("navigation", 16), ("exploration", 96)):
        yield Figure(f"memory of one environment of {task}, all observations but pixels", memory(task), "KiB", wanted)
    yield from growth(seconds)


def counted(program: str, benchmark: str, counter: str) -> float:
    """The median that a benchmark in C++ counts."""
    options = ["--benchmark_repetitions=5", "--benchmark_report_aggregates_only=true", "--benchmark_format=json"]
    words = [PROGRAMS / f"{program}_bench", f"--benchmark_filter=^{benchmark}$", *options]
    results = json.loads(subprocess.run(words, capture_output=True, text=True, check=True).stdout)
    return float(next(one[counter] for one in results["benchmarks"] if one["aggregate_name"] == "median"))


def python_over_cpp(seconds: float) -> Figure:
    """What `step` adds to the call of C++ in it: both in turn, with the same environments, so that both fare alike."""
    kind = Kind(64, 1)
    env = kind.make()
    actions = actions_of(kind.envs)

    def ten_steps(step: Callable[[NDArray[np.float32]], object], turn: int) -> float:
        begin = time.process_time()
        for _ in range(10):
            step(actions[turn % len(actions)])
        return time.process_time() - begin

    shares = []
    end = time.monotonic() + 5.0 * seconds
    while time.monotonic() < end:
        turn = len(shares)
        steps = [(env.step, env._core.step), (env._core.step, env.step)][turn % 2]
        costs = [ten_steps(step, turn) for step in steps]
        shares.append(costs[turn % 2] / costs[1 - turn % 2] - 1.0)
    name = "Python over the C++ that it calls, 64 beams, 1 tick, ideal, gate limits"
    return Figure(name, 100.0 * statistics.median(shares), "%", 5.0)


def two_threads(seconds: float, cpus: set[int]) -> Iterator[Figure]:
    """What the second hardware thread gives environments, as a share of what it gives arithmetic alone.

    By the wall clock: it means something only while nothing else runs.
    """
    if len(cpus) < 2:
        return
    mine = os.sched_getaffinity(0)
    os.sched_setaffinity(0, cpus if len(cpus) == 2 else set(sorted(cpus)[-2:]))
    gains, spins = [], []
    for _ in range(3):
        one, two = (min(measure(Kind(64, 5, threads=threads), seconds, time.perf_counter)) for threads in (1, 2))
        gains.append(one / two)
        words = [[SPIN, str(threads), str(seconds / 2)] for threads in (1, 2)]
        loops = [float(subprocess.run(each, capture_output=True, text=True, check=True).stdout) for each in words]
        spins.append(loops[1] / loops[0])
    os.sched_setaffinity(0, mine)
    name = f"two threads over one {max(gains):.2f}, arithmetic alone {max(spins):.2f}: a share of"
    yield Figure(name, max(gains) / max(spins), "", 0.9, at_least=True)


def ppo(cpus: set[int]) -> Iterator[Figure]:
    """Samples that the PPO example takes and learns from, by the wall clock: it means something only while nothing else
    runs. Wanted is twice what it was when it took 72 s for 655,360 of them.
    """
    if len(cpus) < 2:
        return
    mine = os.sched_getaffinity(0)
    os.sched_setaffinity(0, cpus)
    for noise in ("ideal", "realistic"):
        words = [sys.executable, __file__, "--ppo", noise]
        rate = float(subprocess.run(words, capture_output=True, text=True, check=True).stdout.splitlines()[-1])
        yield Figure(f"PPO example end to end, two threads, {noise}", rate, "1/s", 18e3, at_least=True)
    os.sched_setaffinity(0, mine)


def ppo_samples(noise: str) -> float:
    """Samples a second, once scenes and tables are there."""
    sys.path.insert(0, str(HERE.parent / "examples"))
    example = importlib.import_module("09_ppo")
    _, (first, *_, last) = example.train(example.Settings(lessons=((noise, 4, 8),)))
    return float((last["steps"] - first["steps"]) / (last["wall_s"] - first["wall_s"]))


def memory(task: str) -> float:
    """[KiB] by which a process grows for one more environment of the default robot."""
    few, many = 256, 2304
    sizes = []
    for envs in (few, many):
        words = [sys.executable, __file__, "--memory", task, str(envs)]
        sizes.append(int(subprocess.run(words, capture_output=True, text=True, check=True).stdout))
    return (sizes[1] - sizes[0]) / (many - few) / 1024.0


def resident(task: str, envs: int) -> int:
    """Bytes of this process, once such environments have run for a while."""
    fields = {"navigation": "goal", "exploration": "coverage_map"}
    options = {
        "task": task,
        "hardware": "3we_standard_v2",
        "observations": ("lidar", "pose", "velocity", fields[task]),
    }
    env = Kind(ticks=5, noise="realistic", gate="full", envs=envs, options=options).make()
    for action in env.action_space.sample()[None].repeat(20, axis=0):
        env.step(action)
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")


def growth(seconds: float) -> Iterator[Figure]:
    """How much faster than linear cost grows: 1 is linear, less is better."""
    costs = {envs: min(measure(Kind(64, 5, envs=envs), seconds)) for envs in ENVS}
    listed = ", ".join(f"{1e9 * cost:.0f}" for cost in costs.values())
    yield Figure(
        f"1 to 16,384 at once: {listed} ns a step; last over best", costs[ENVS[-1]] / min(costs.values()), "", 1.1
    )

    few, many = (min(measure(Kind(beams, 1), seconds)) for beams in (64, 360))
    yield Figure(
        f"beams 64 to 360: {1e9 * few:.0f} to {1e9 * many:.0f} ns; growth over 5.6", many / few / (360 / 64), "", 1.0
    )

    few, many = (min(measure(pictures(size), seconds)) for size in (64, 128))
    yield Figure(
        f"pixels 64x64 to 128x128: {1e6 * few:.0f} to {1e6 * many:.0f} us; growth over 4", many / few / 4, "", 1.0
    )

    scenes = [Scene.generate(1, difficulty=difficulty) for difficulty in (0.0, 1.0)]
    bare, full = (sum(len(thing.prisms) for thing in scene.objects) + len(scene.walls) for scene in scenes)
    few, many = (min(measure(Kind(64, 1, options={"scene": scene}), seconds)) for scene in scenes)
    name = f"solids {bare} to {full}: {1e9 * few:.0f} to {1e9 * many:.0f} ns; growth over {full / bare:.1f}"
    yield Figure(name, many / few / (full / bare), "", 1.0)


def pictures(size: int) -> Kind:
    """With a camera, colour and depth, and nothing else."""
    options = {"observations": ("image", "depth"), "image_size": (size, size), "hardware": "3we_depth_v2"}
    return Kind(ticks=5, envs=64, options=options)


if __name__ == "__main__":
    raise SystemExit(main())
