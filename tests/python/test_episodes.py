"""The frozen sets of episodes are what they say, and driving them is repeatable."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import threewe
from numpy.typing import NDArray
from threewe import ConfigError
from threewe.benchmark import load_episodes
from threewe.gym.episodes import evaluate

SCENES = ["office_v2", "apartment_v1", "corridor_v1", "warehouse_v1", "cluttered_v1", "outdoor_v1", "dynamic_v1"]
FAST: dict[str, Any] = {"observations": ("lidar", "goal"), "lidar_beams": 72, "max_steps": 60}


def test_the_reactive_set_is_a_hundred_episodes_in_each_scene() -> None:
    reactive = load_episodes("reactive_v1")
    assert [episode.scene for episode in reactive["episodes"]] == [scene for scene in SCENES for _ in range(100)]
    assert len({(episode.scene, episode.seed) for episode in reactive["episodes"]}) == 700
    assert (reactive["shortest"], reactive["longest"], reactive["straightness"]) == (2.0, 8.0, 1.3)


@pytest.mark.parametrize("scene", SCENES)
def test_the_reactive_set_satisfies_its_definition(scene: str) -> None:
    reactive = load_episodes("reactive_v1")
    tables = threewe.SceneTables(threewe.Scene.load(scene), threewe.RobotProfile.load(reactive["hardware"]))
    listed = [episode for episode in reactive["episodes"] if episode.scene == scene]
    for episode in listed:
        straight = math.dist(episode.start[:2], episode.goal)
        assert 2.0 <= episode.geodesic <= 8.0
        assert episode.geodesic <= 1.3 * straight
        assert tables.clearance(threewe.Pose2D(*episode.start)) >= 0.05
        assert tables.clearance(threewe.Pose2D(*episode.goal, 0.0)) >= 0.05
    # those that are listed were drawn as it says, and between two of them is none that should be
    for episode in listed[:3] + listed[-3:]:
        drawn = tables.sample_episode(reactive["seed"], episode.index)
        assert (drawn.start.x, drawn.start.y, drawn.start.theta) == episode.start
        assert tuple(drawn.goal) == episode.goal
        assert (drawn.geodesic, drawn.seed) == (episode.geodesic, episode.seed)
    for index in set(range(listed[4].index)) - {episode.index for episode in listed}:
        drawn = tables.sample_episode(reactive["seed"], index)
        straight = math.dist((drawn.start.x, drawn.start.y), drawn.goal)
        assert drawn.geodesic > 8.0 or drawn.geodesic > 1.3 * straight


def straight_ahead(observations: dict[str, NDArray[Any]]) -> NDArray[np.float32]:
    goal = observations["goal"]
    actions = np.zeros((len(goal), 3), np.float32)
    actions[:, :2] = goal / np.linalg.norm(goal, axis=1, keepdims=True)
    return actions


def test_outcomes_do_not_depend_on_who_else_is_on_the_list() -> None:
    listed = load_episodes("reactive_v1")["episodes"]
    few = [listed[0], listed[1], listed[600], listed[601]]
    together = evaluate(straight_ahead, few, num_threads=2, **FAST)
    alone = [evaluate(straight_ahead, [episode], **FAST)[0] for episode in reversed(few)]
    assert together == alone[::-1]
    assert all(outcome.metrics["shortest_path"] == pytest.approx(outcome.episode.geodesic, rel=0.03, abs=0.1)
               for outcome in together)  # fmt: skip
    assert all(outcome.success or outcome.steps == 60 or outcome.metrics["collision_speed"] > 0.05
               for outcome in together)  # fmt: skip


def test_a_robot_that_knows_the_truth_has_the_same_outcomes() -> None:
    listed = load_episodes("reactive_v1")["episodes"]
    few = [listed[0], listed[100], listed[600]]
    native = evaluate(straight_ahead, few, localization="truth", **FAST)
    assert evaluate(straight_ahead, few, localization="truth", backend="mock", **FAST) == native
    assert len(evaluate(straight_ahead, few[:1], backend="mock", **FAST)) == 1


def test_unknown_sets_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="did you mean 'reactive_v1'"):
        load_episodes("reactive_v2")
    with pytest.raises(ConfigError, match=r"none\.json: no such file"):
        load_episodes(tmp_path / "none.json")
