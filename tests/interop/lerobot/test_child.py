"""Policies in LeRobot's own Python, driven from here: what comes over the pipe is what LeRobot gives."""

from __future__ import annotations

import asyncio
import json
import os
from pathlib import Path

import numpy as np
import pytest
from threewe import ConfigError, Robot
from threewe.ai import VLARunner

from tests.interop.lerobot.asking import Ask
from tests.interop.lerobot.test_policies import lerobot, renamed, theirs, trained
from verify.cases.act_checkpoints import SHAPES, Shape, observations

__all__ = ["lerobot"]
PYTHON = os.environ["LEROBOT_PYTHON"]


@pytest.mark.parametrize("name", ["64", "120"])
def test_act_in_a_child_is_lerobots_own(lerobot: Ask, tmp_path: Path, name: str) -> None:
    shape = SHAPES[name]
    root = tmp_path / "act"
    trained(
        lerobot, root, shape, "act", {"pretrained_backbone_weights": None, "chunk_size": 10, "n_action_steps": 10}, 2
    )
    runner = VLARunner.from_pretrained(root, rate=10, rename=renamed(shape), python=PYTHON)
    given = observations(shape, 5, seed=5)
    found = np.array([runner._engine.infer(each, "go")[0] for each in given])
    np.testing.assert_allclose(found, theirs(lerobot, root, given), rtol=0, atol=1e-5)


def test_diffusion_in_a_child(lerobot: Ask, tmp_path: Path) -> None:
    shape = Shape(64, 64, text=False)
    root = tmp_path / "diffusion"
    options = {
        "pretrained_backbone_weights": None,
        "down_dims": [32, 64],
        "horizon": 8,
        "n_action_steps": 7,
        "num_inference_steps": 5,
    }
    trained(lerobot, root, shape, "diffusion", options, 0)
    runner = VLARunner.from_pretrained(root, rate=10, rename=renamed(shape), python=PYTHON)
    assert runner.policy.chunk >= 2
    given = observations(shape, 2, seed=5)
    first, second = (runner._engine.infer(each, "")[0] for each in given)
    np.testing.assert_array_equal(first, runner._engine.infer(given[0], "")[0])  # its noise is the same each time
    assert np.isfinite(first).all()
    assert np.abs(first - second).max() > 0


VLA = Shape(64, 64, text=False)


@pytest.fixture
def smolvla(lerobot: Ask, tmp_path: Path) -> Path:
    """The folder of a SmolVLA of half a million drawn weights, beside its backbone."""
    root, backbone = tmp_path / "smolvla", tmp_path / "backbone"
    backbone.mkdir()
    lerobot("backbone", root=backbone)
    sizes = {"num_vlm_layers": 2, "expert_width_multiplier": 0.5, "max_state_dim": 8, "max_action_dim": 8}
    options = {
        "vlm_model_name": str(backbone),
        "load_vlm_weights": False,
        "chunk_size": 8,
        "n_action_steps": 8,
        "resize_imgs_with_padding": [64, 64],
        "tokenizer_max_length": 32,
        "num_steps": 3,
        **sizes,
    }
    inputs = VLA.config()["input_features"]
    made = lerobot("train", root=root, kind="smolvla", options=options, inputs=inputs, numbers=3, steps=0)
    assert 4e5 < made["weights"] < 7e5
    return root


def load(root: Path) -> VLARunner:
    return VLARunner.from_pretrained(root, rate=10, rename=renamed(VLA), python=PYTHON)


def test_smolvla_in_a_child(lerobot: Ask, smolvla: Path) -> None:
    runner = load(smolvla)
    assert (runner.policy.chunk, runner.policy.language, runner.policy.prefix) == (8, True, 0)
    given = observations(VLA, 3, seed=5)
    found = np.array([runner._engine.infer(each, "go to the chair")[0] for each in given])
    np.testing.assert_allclose(found, theirs(lerobot, smolvla, given, "go to the chair"), rtol=0, atol=1e-5)
    other = runner._engine.infer(given[0], "stop at the plant")[0]
    assert np.abs(other - found[0]).max() > 1e-6  # it reads its text

    async def drive() -> str:
        async with Robot(image_size=(64, 64)) as robot:
            return (await runner.run(robot, "go to the chair", timeout=1.0)).reason

    assert asyncio.run(drive()) in ("timeout", "reached")
    (smolvla.with_name("backbone") / "weights.bin").write_bytes(b"\x80\x04.")
    with pytest.raises(ConfigError, match=r"weights\.bin: pickled"):
        load(smolvla)


def test_rtc_follows_what_is_committed(lerobot: Ask, smolvla: Path) -> None:
    config = json.loads((smolvla / "config.json").read_text())
    rtc = {"enabled": True, "execution_horizon": 8, "max_guidance_weight": 10.0, "prefix_attention_schedule": "LINEAR"}
    (smolvla / "config.json").write_text(json.dumps({**config, "num_steps": 10, "rtc_config": rtc}))
    runner = load(smolvla)
    assert runner.policy.prefix == 7
    task = "go to the chair"
    committed = [[0.3 + 0.02 * k, 0.1, -0.2 + 0.05 * k] for k in range(5)]
    prefix = np.zeros((1, 7, 4), np.float32)
    prefix[0, :5] = [[*action, 1.0] for action in committed]
    off = []
    for given in observations(VLA, 3, seed=5):
        free, guided = (
            runner._engine.infer({**given, "action.prefix": prefix * on}, task)[0] for on in (np.float32(0), 1)
        )
        np.testing.assert_allclose(free, theirs(lerobot, smolvla, [given], task)[0], rtol=0, atol=1e-5)
        np.testing.assert_allclose(guided, theirs(lerobot, smolvla, [given], task, committed)[0], rtol=0, atol=1e-5)
        off.append([np.abs(each[:5] - committed).mean() for each in (free, guided)])
        assert np.abs(guided[5:] - free[5:]).max() > 0  # what follows goes on from there
    print("away from what is committed, without and with rtc:", *np.mean(off, 0))
    assert all(guided < 0.25 * free for free, guided in off)

    async def drive() -> tuple[str, int]:
        async with Robot(image_size=(64, 64)) as robot:
            result = await runner.run(robot, task, timeout=2.0)
            return result.reason, result.inferences

    reason, inferences = asyncio.run(drive())
    assert reason in ("timeout", "reached")
    assert inferences > 3
