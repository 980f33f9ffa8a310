"""Episodes of the benchmarks, driven by the shipped agents: bundles, genuine and forged, their bits and their cost."""

import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from threewe import available_targets, force_target
from threewe.benchmark import Episode, load_episodes, load_results
from threewe.benchmark.attempt import Settings, attempt
from threewe.benchmark.bundle import BundleError, write_bundle
from threewe.benchmark.run import plan_run, results_of, run
from threewe.benchmark.sampling import SCENES
from threewe.benchmark.unseen import SUFFIX
from threewe.benchmark.verifying import verify_bundle

from verify.cases.forgeries import Forger

GENUINE = ("pointnav", "navigator"), ("pointnav", "straight"), ("objectnav", "semantic"), ("exploration", "navigator")
SPLIT = "val"
THREEWE = Path(sys.executable).parent / "threewe"


def drive(seed: int, task: str, scene: str, agents: list[str]) -> dict[str, Any]:
    """One episode of a scene, by each of the agents."""
    listed = episodes_of(task, scene)
    episode = listed[seed % len(listed)]
    return {"episode": episode.index, **{agent: metrics(task, episode, agent) for agent in agents}}


def episodes_of(task: str, scene: str) -> list[Episode]:
    """Returns the frozen episodes of a task in a scene."""
    split = "unseen" if scene.endswith(SUFFIX) else SPLIT
    return [episode for episode in load_episodes(f"{task}_{split}_v1")["episodes"] if episode.scene == scene]


def metrics(task: str, episode: Episode, agent: str) -> dict[str, Any]:
    """What one of them came to."""
    return dict(attempt(task, episode, agent, Settings())["metrics"])


def cost(seed: int, episodes: int, workers: int) -> dict[str, Any]:
    """What the commands take that run so many episodes in each scene of PointNav and that verify the bundle."""
    with tempfile.TemporaryDirectory() as folder:
        few = ["--workers", str(workers)]
        drive = ["run", "pointnav", "--scene", "all", "--episodes", str(episodes), "--seed", str(seed % 1000), *few]
        run_took = command(folder, *drive, "--agent", "navigator", "--output", "results.json", "--bundle", "run.zip")
        verify_took = command(folder, "verify", "run.zip", *few)
        count = len(load_results(Path(folder, "results.json"))["episode_results"])
    return {"episodes": count, "run": run_took, "verify": verify_took}


def command(folder: str, *arguments: str) -> dict[str, float]:
    """Seconds of the wall and of processors that `threewe benchmark` took, worker processes included."""
    before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    subprocess.run([THREEWE, "benchmark", *arguments], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    wall, after = time.monotonic() - begun, resource.getrusage(resource.RUSAGE_CHILDREN)
    return {"wall": wall, "cpu": after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime}


def on_targets(seed: int, task: str, agent: str) -> dict[str, Any]:
    """Two episodes on each vector target of this machine: whether the results are the same bytes."""
    scene = SCENES[task][seed % len(SCENES[task])]
    plan, listed = plan_run(task, agent, split=SPLIT, scenes=[scene], episodes=2, settings=Settings())
    written = {}
    try:
        for target in available_targets():
            force_target(target)
            with tempfile.TemporaryDirectory() as folder:
                outcomes = run(plan, listed, Path(folder, "journal.jsonl"), workers=0)
                write_bundle(Path(folder, "run.zip"), results_of(plan, listed, outcomes), outcomes)
                written[target] = Path(folder, "run.zip").read_bytes()
    finally:
        force_target("")
    return {"scene": scene, "equal": len(set(written.values())) == 1, "targets": sorted(written)}


def forge(seed: int, forgeries: int) -> dict[str, Any]:
    """A genuine bundle, and so many forged ones: which were not judged as they should be."""
    task, agent = GENUINE[seed % len(GENUINE)]
    with tempfile.TemporaryDirectory() as folder:
        genuine = Path(folder, "genuine.zip")
        scene = SCENES[task][seed // len(GENUINE) % len(SCENES[task])]
        plan, listed = plan_run(task, agent, split=SPLIT, scenes=[scene], episodes=2, settings=Settings())
        outcomes = run(plan, listed, Path(folder, "journal.jsonl"), workers=0)
        write_bundle(genuine, results_of(plan, listed, outcomes), outcomes)
        passed = refusal(genuine) == ""
        accepted = []
        for number in range(forgeries):
            kind, content = Forger(genuine, seed + number).forged()
            forged = Path(folder, "forged.zip")
            forged.write_bytes(content)
            if refusal(forged) == "":
                accepted.append(f"{kind}, seed {seed + number}")
    return {"agent": f"{task}, {agent}", "passed": passed, "forgeries": forgeries, "accepted": accepted}


def refusal(bundle: Path) -> str:
    """Why a bundle is refused; empty where it is not."""
    try:
        verify_bundle(bundle, workers=0)
    except BundleError as error:
        return str(error)
    return ""
