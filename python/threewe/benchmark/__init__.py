"""Benchmarks: frozen episodes, agents, metrics with intervals, and results that anyone can replay.

from pathlib import Path

from threewe.benchmark import Settings, plan_run, results_of, run

plan, episodes = plan_run("pointnav", "navigator", split="val", scenes=["office_v2"], episodes=2, settings=Settings())
results = results_of(plan, episodes, run(plan, episodes, Path("journal.jsonl")))
print(results["summary"]["all"]["success"])
"""

from threewe._core import ReferenceDrive, ReferenceExploration, nearest_frontier, optimistic_replanning, spl
from threewe.benchmark.agents import Identity
from threewe.benchmark.attempt import Settings
from threewe.benchmark.bundle import BundleError, write_bundle
from threewe.benchmark.episodes import Episode, EpisodeSet, Outcome, Yardstick, load_episodes
from threewe.benchmark.mlp import MlpPolicy
from threewe.benchmark.mlp_export import mlp_from_sb3, mlp_from_torch
from threewe.benchmark.results import compare, load_results, summarize
from threewe.benchmark.run import Plan, plan_run, results_of, run
from threewe.benchmark.sampling import training_episodes
from threewe.benchmark.submission import Server, load_server, save_server, submit_bundle
from threewe.benchmark.tasks import Assignment
from threewe.benchmark.verifying import Verified, verify_bundle

__all__ = [
    "Assignment",
    "BundleError",
    "Episode",
    "EpisodeSet",
    "Identity",
    "MlpPolicy",
    "Outcome",
    "Plan",
    "ReferenceDrive",
    "ReferenceExploration",
    "Server",
    "Settings",
    "Verified",
    "Yardstick",
    "compare",
    "load_episodes",
    "load_results",
    "load_server",
    "mlp_from_sb3",
    "mlp_from_torch",
    "nearest_frontier",
    "optimistic_replanning",
    "plan_run",
    "results_of",
    "run",
    "save_server",
    "spl",
    "submit_bundle",
    "summarize",
    "training_episodes",
    "verify_bundle",
    "write_bundle",
]
