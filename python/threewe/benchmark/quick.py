"""Quick runs: all episodes of an agent that acts at once, in the native batch with its model of a localizer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from threewe._core import Pose2D
from threewe.benchmark.agents import make_agent
from threewe.benchmark.attempt import Attempt, assignment_of, record, requested_options
from threewe.benchmark.buildings import scene_asset
from threewe.benchmark.episodes import Episode, Outcome
from threewe.benchmark.run import Plan
from threewe.benchmark.runner import Result
from threewe.benchmark.tasks import CONTACT_SPEED, TASKS, Metrics, Task, soft_spl
from threewe.errors import ConfigError
from threewe.gym.episodes import evaluate


def run_quick(plan: Plan, episodes: Sequence[Episode], *, threads: int = 1) -> list[Result]:
    """What each episode came to: figures for development, which no replay can show.

    An agent that raises ends the run. Raises ConfigError for a program around a `Robot`, and for explorations.
    """
    task = TASKS[plan.task]
    if plan.agent.kind != "act" or task.name == "exploration":
        raise ConfigError("quick: the native batch is for PointNav and ObjectNav, and for agents that act")
    agents = [make_agent(plan.task, plan.agent.name) for _ in episodes]
    for agent, episode in zip(agents, episodes, strict=True):
        if hasattr(agent, "reset"):
            agent.reset(assignment_of(task, episode, plan.settings, Pose2D()))
    options = requested_options(agents[0], task, plan.settings)

    def policy(observations: dict[str, NDArray[Any]]) -> NDArray[np.float32]:
        rows = ({name: values[i] for name, values in observations.items()} for i in range(len(agents)))
        return np.array([agent.act(row) for agent, row in zip(agents, rows, strict=True)], np.float32)

    outcomes = evaluate(
        policy,
        episodes,
        task=task.environment,
        hardware=plan.settings.hardware,
        noise=plan.settings.noise,
        randomization=plan.settings.randomization,
        gate="full",
        max_steps=round(task.time_limit(episodes[0]) * options["control_rate"]),
        num_threads=threads,
        scene=list(dict.fromkeys(scene_asset(episode.scene) for episode in episodes)),
        **options,
    )
    return [record(_attempt(one), _metrics(task, one, options["control_rate"])) for one in outcomes]


def _attempt(outcome: Outcome) -> Attempt:
    return Attempt("stop" if outcome.metrics["stopped"] else "time")


def _metrics(task: Task, outcome: Outcome, control_rate: float) -> Metrics:
    """Those of the environment, by the names of the benchmark's."""
    seen, success = outcome.metrics, float(outcome.success)
    metrics: Metrics = {
        "success": success,
        "success_without_contact": success * (seen["collision_speed"] <= CONTACT_SPEED),
        "spl": seen["spl"],
        "contacts": seen.get("contacts", float(seen["collision_speed"] > CONTACT_SPEED)),
        "collision_speed": seen["collision_speed"],
        "path_length": seen["path_length"],
        "duration": outcome.steps / control_rate,
        "distance_to_success": 0.0 if success else seen["distance_to_goal"],
    }
    if task.name == "pointnav":
        metrics["soft_spl"] = soft_spl(
            0.0 if success else seen["distance_to_goal"], outcome.episode.geodesic, seen["path_length"]
        )
    return metrics
