"""Checkpoints in a process of another Python: arrays go over a pipe, and whatever becomes of it is one error."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from threewe import ConfigError, HardwareError, Robot, Velocity
from threewe.ai import VLARunner, child
from threewe.cli import app
from typer.testing import CliRunner

from verify.cases import act_checkpoints
from verify.cases.act_checkpoints import STATE, Shape

NAMES = {"action": ["vx", "vy", "omega"], STATE: ["vx", "vy", "omega"]}
SHAPE = Shape(24, 32, text=False, options={"type": "fake", "n_obs_steps": 2})
TOKENIZER = {"registry_name": "tokenizer_processor", "config": {"tokenizer_name": "none"}}


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = act_checkpoints.write(tmp_path_factory.mktemp("made") / "fake", SHAPE)
    (folder / "model.safetensors").write_bytes(b"")
    content = json.loads((folder / "policy_preprocessor.json").read_text())
    content["steps"].append(TOKENIZER)
    (folder / "policy_preprocessor.json").write_text(json.dumps(content))
    return folder


@pytest.fixture
def load(made: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., VLARunner]:
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).with_name("fake_lerobot")))

    def loaded(python: str | Path = sys.executable, **config: Any) -> VLARunner:
        right = json.dumps({**SHAPE.config(), **config})
        (made / "config.json").write_text(right)
        return VLARunner.from_pretrained(made, python=python, rate=10, rename=NAMES)

    return loaded


def test_it_computes_what_the_child_does(load: Callable[..., VLARunner]) -> None:
    runner = load()
    assert (runner.policy.chunk, runner.policy.language) == (5, True)
    red = np.zeros((24, 32, 3), np.uint8)
    red[:, :, 2] = 51  # BGR
    chunk = runner.predict_chunk(red, "go", velocity=Velocity(0.0, 0.25, 0.0))
    assert chunk == pytest.approx(np.tile([0.2, 0.25, 2.0], (5, 1)))
    large = load(
        input_features={
            **SHAPE.config()["input_features"],
            "observation.images.camera": {"type": "VISUAL", "shape": [3, 960, 1280]},
        }
    )
    assert large.predict(np.full((960, 1280, 3), 9, np.uint8), "go", velocity=Velocity()) == pytest.approx([0, 0, 2])


RTC = {"enabled": True, "execution_horizon": 10}


def test_committed_actions_go_to_the_child_where_rtc_is_on(load: Callable[..., VLARunner]) -> None:
    picture, committed = np.zeros((24, 32, 3), np.uint8), [Velocity(0.3, 0.1, -0.4), Velocity(0.2, 0.0, 0.5)]

    def chunk(runner: VLARunner, wanted: list[Velocity]) -> NDArray[np.float32]:
        feed = runner._feed(picture, "go", Velocity(0.0, 0.25, 0.0), wanted)
        return runner._engine.infer(feed, "go")[0]

    free = np.tile([0.0, 0.25, 2.0], (5, 1))
    runner = load(rtc_config={**RTC, "enabled": False})
    assert runner.policy.prefix == 0
    assert chunk(runner, committed) == pytest.approx(free, abs=1e-6)
    runner = load(rtc_config=RTC)
    assert runner.policy.prefix == 4
    assert chunk(runner, []) == pytest.approx(free, abs=1e-6)
    assert chunk(runner, committed) == pytest.approx(np.array([*committed, *free[2:]]), abs=1e-6)
    assert "on: the actions that are committed" in info(runner.policy.folder)
    with pytest.raises(ConfigError, match="rtc_config: 'fake' has no real-time chunking"):
        load(rtc_config=RTC, fake_old=True)


def info(folder: Path) -> str:
    result = CliRunner().invoke(app, ["policy", "info", str(folder)], env={"COLUMNS": "120"})
    assert result.exception is None
    return result.output


def test_info_says_what_a_checkpoint_needs(made: Path) -> None:
    for rtc, said in ((None, "off: "), ({**RTC, "enabled": False}, "off: "), (RTC, "on: ")):
        (made / "config.json").write_text(json.dumps({**SHAPE.config(), "rtc_config": rtc}))
        assert f"rtc                       │ {said}" in info(made)
    (made / "config.json").write_text(json.dumps(SHAPE.config()))
    output = info(made)
    assert "VISUAL, 3 x 24 x 32" in output
    assert "python=" in output
    assert "tokens" in output
    assert "rtc" not in output


def test_a_run_hands_over_what_it_has_committed(load: Callable[..., VLARunner]) -> None:
    runner = load(rtc_config=RTC)
    infer, given = runner._engine.infer, []

    def watched(feed: Any, instruction: str) -> Any:
        actions = infer(feed, instruction)
        given.append((feed["action.prefix"][0], actions[0]))
        return actions

    runner._engine = SimpleNamespace(infer=watched)  # type: ignore[assignment]

    async def drive() -> str:
        async with Robot(image_size=(24, 32)) as robot:
            return (await runner.run(robot, "go", timeout=1.5)).reason

    assert asyncio.run(drive()) == "timeout"
    counts = [int(prefix[:, 3].sum()) for prefix, _ in given]
    assert counts[0] == 0  # nothing has been wanted yet
    assert min(counts[3:]) >= 2
    for (prefix, actions), count in zip(given, counts, strict=True):
        assert actions[:count] == pytest.approx(prefix[:count, :3], abs=1e-6)


FAULTS = {
    "raises": r"LeRobot: RuntimeError: broken",
    "killed": r"ended \(signal 9",
    "exits": r"ended \(status 1: a last word\)",
    "hangs": "hangs, and was ended",
    "garbage": "sent what is no answer",
}


@pytest.mark.parametrize("fault", list(FAULTS))
def test_a_fault_of_the_child_is_one_error(
    load: Callable[..., VLARunner], fault: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    runner = load(fake_fault=fault)
    monkeypatch.setattr(child, "PATIENCE", 1.0 if fault == "hangs" else 60.0)
    picture = np.zeros((24, 32, 3), np.uint8)
    with pytest.raises(HardwareError, match=FAULTS[fault]):
        runner.predict(picture, "go", velocity=Velocity())
    if fault != "raises":
        with pytest.raises(HardwareError, match="ended"):
            runner.predict(picture, "go", velocity=Velocity())


def test_a_child_that_is_killed_stops_the_robot(load: Callable[..., VLARunner]) -> None:
    runner = load()

    async def drive() -> tuple[str, str]:
        async with Robot(image_size=(24, 32)) as robot:
            task = asyncio.ensure_future(runner.run(robot, "go", timeout=5.0))
            await robot.sleep(0.5)
            os.kill(runner._engine._process.pid, signal.SIGKILL)  # type: ignore[attr-defined]
            result = await task
            await robot.move_forward(0.1)
            return result.reason, result.detail

    reason, detail = asyncio.run(drive())
    assert reason == "policy_error"
    assert "signal 9" in detail


def test_what_cannot_be_started_is_one_error(
    load: Callable[..., VLARunner], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(ConfigError, match="LeRobot does not load it: ValueError: no such weights"):
        load(fake_fault="loading")
    with pytest.raises(ConfigError, match=r"python: .*nothing: no such file"):
        load(tmp_path / "nothing")
    (tmp_path / "text").write_text("text")
    with pytest.raises(ConfigError, match="cannot be run"):
        load(tmp_path / "text")
    script = tmp_path / "python"
    script.write_text("#!/bin/sh\nexit 3\n")
    script.chmod(0o755)
    with pytest.raises(ConfigError, match=r"ended \(status 3\)"):
        load(script)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    with pytest.raises(ConfigError, match=r"has no LeRobot \(No module named 'lerobot.*install it there"):
        load()


def test_a_checkpoint_is_vetted_before_the_child_sees_it(
    made: Path, load: Callable[..., VLARunner], tmp_path: Path
) -> None:
    started = tmp_path / "started"
    script = tmp_path / "python"
    script.write_text(f"#!/bin/sh\ntouch {started}\n")
    script.chmod(0o755)
    processor = made / "policy_postprocessor.json"
    right = processor.read_text()
    processor.write_text(json.dumps({"steps": [{"class": "os.system", "config": {"command": "true"}}]}))
    with pytest.raises(ConfigError, match=r"steps\[0\]\.class: 'os\.system' would be imported"):
        load(script)
    processor.write_text(right)
    backbone = tmp_path / "backbone"
    backbone.mkdir()
    (backbone / "pytorch_model.bin").write_bytes(b"")
    with pytest.raises(ConfigError, match=r"pytorch_model\.bin: pickled"):
        load(script, vlm_model_name=str(backbone))
    assert not started.exists()
