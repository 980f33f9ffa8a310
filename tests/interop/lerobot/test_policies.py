"""Policies that LeRobot trained give here what they give there. `./dev interop lerobot`."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from threewe.ai import VLARunner
from threewe.ai.collecting import Collection, collect_demonstrations
from threewe.ai.training import train_policy

from tests.interop.lerobot.asking import Ask, peer_of
from verify.cases.act_checkpoints import SHAPES, STATE, Shape, observations

NAMES = ["vx", "vy", "omega"]
COUNTS = {"64": 400, "120": 300, "240": 200, "480": 100}


@pytest.fixture(scope="module")
def lerobot() -> Iterator[Ask]:
    """LeRobot in a process of its own."""
    with peer_of("policies_peer.py") as ask:
        yield ask


def trained(
    lerobot: Ask, root: Path, shape: Shape, kind: str, options: dict[str, Any], steps: int
) -> NDArray[np.float64]:
    """Trains a checkpoint; the range of the actions that it was trained on."""
    inputs = shape.config()["input_features"]
    answer = lerobot("train", root=root, kind=kind, options=options, inputs=inputs, numbers=shape.actions, steps=steps)
    losses = answer["losses"]
    assert not losses or losses[-1] < losses[0]
    return np.array(answer["range"])


def theirs(
    lerobot: Ask,
    root: Path,
    given: list[dict[str, NDArray[np.float32]]],
    task: str | None = None,
    committed: list[list[float]] | None = None,
) -> NDArray[np.float32]:
    """LeRobot's own chunks."""
    arrays, out = root.with_suffix(".npz"), root.with_suffix(".out.npz")
    np.savez(arrays, **{f"{i}/{name}": values for i, each in enumerate(given) for name, values in each.items()})
    lerobot("predict", root=root, arrays=arrays, out=out, task=task, committed=committed)
    with np.load(out) as found:
        return np.array([found[str(i)] for i in range(len(given))])


def renamed(shape: Shape) -> dict[str, list[str]]:
    return {"action": NAMES, **({STATE: NAMES} if shape.state else {})}


@pytest.mark.parametrize("name", list(SHAPES))
def test_act_gives_the_same_actions(lerobot: Ask, tmp_path: Path, name: str) -> None:
    shape = SHAPES[name]
    config = shape.config()
    kept = ("chunk_size", "n_action_steps", "pre_norm", "feedforward_activation", "temporal_ensemble_coeff")
    options = {key: config[key] for key in (*kept, "n_decoder_layers")}
    options |= {"normalization_mapping": shape.modes, "pretrained_backbone_weights": None}
    options |= {"dim_model": 128, "n_heads": 4, "dim_feedforward": 256}
    root = tmp_path / "act"
    learnt = trained(lerobot, root, shape, "act", options, {"64": 60, "120": 40, "240": 20, "480": 10}[name])
    given = observations(shape, COUNTS[name], seed=5)
    began = time.process_time()
    runner = VLARunner.from_pretrained(root, rate=10, rename=renamed(shape))
    seconds = time.process_time() - began
    expected = theirs(lerobot, root, given)
    found = np.array([runner._engine.infer(each, "")[0] for each in given])
    difference, own = np.abs(found - expected).max((0, 1)), np.ptp(expected, (0, 1))
    print(f"{name}: {len(given)} observations, loaded in {seconds:.2f} s of CPU; differs by {difference.max():.1e}:")
    print(f"  {(difference / own).max():.1e} of their range, which is {own}; that to learn is {learnt}")
    assert (difference / own).max() <= 1e-5
    assert seconds <= 2.0


def test_lerobot_loads_an_act_that_we_trained(lerobot: Ask, tmp_path: Path) -> None:
    asyncio.run(collect_demonstrations(tmp_path / "demos", 4, Collection(scene="office_v2", seed=5)))
    root = tmp_path / "act"
    train_policy([tmp_path / "demos"], root, 2, 1, 0, print, "act")
    given = observations(Shape(60, 80, state=0), 100, seed=5)
    expected = theirs(lerobot, root, given)
    found = np.array([VLARunner.from_pretrained(root)._engine.infer(each, "")[0] for each in given])
    difference = np.abs(found - expected).max() / np.ptp(expected)
    print(f"ours, by LeRobot: differs by {difference:.1e} of the range")
    assert difference <= 1e-5
