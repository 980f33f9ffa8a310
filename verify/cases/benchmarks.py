"""Episodes of the benchmarks, driven by the shipped agents; bundles of them, genuine and forged."""

import tempfile
from pathlib import Path
from typing import Any

from threewe.benchmark import Episode, load_episodes
from threewe.benchmark.attempt import Settings, attempt
from threewe.benchmark.bundle import BundleError, write_bundle
from threewe.benchmark.run import plan_run, results_of, run
from threewe.benchmark.sampling import SCENES
from threewe.benchmark.unseen import SUFFIX
from threewe.benchmark.verifying import verify_bundle

from verify.cases.forgeries import Forger

GENUINE = ("pointnav", "navigator"), ("pointnav", "straight"), ("objectnav", "semantic"), ("exploration", "navigator")
SPLIT = "val"


def drive(seed: int, task: str, scene: str, agents: list[str]) -> dict[str, Any]:
    """One episode of a scene, by each of the agents."""
    split = "unseen" if scene.endswith(SUFFIX) else SPLIT
    listed = [episode for episode in load_episodes(f"{task}_{split}_v1")["episodes"] if episode.scene == scene]
    episode: Episode = listed[seed % len(listed)]
    return {"episode": episode.index, **{agent: metrics(task, episode, agent) for agent in agents}}


def metrics(task: str, episode: Episode, agent: str) -> dict[str, Any]:
    """What one of them came to."""
    return dict(attempt(task, episode, agent, Settings())["metrics"])


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
