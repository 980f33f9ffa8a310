"""Policies in other forms: eight bits, stages for a Hailo, and LeRobot's checkpoints as folders of ours."""

from __future__ import annotations

import asyncio
import shutil
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import pytest
from ai import hailort, policies
from threewe import ConfigError, HardwareError, Robot
from threewe.ai import VLARunner, read_policy
from threewe.ai.calibration import calibration_feeds
from threewe.ai.cutting import write_for_hailo
from threewe.ai.folder import write_policy
from threewe.ai.quantizing import write_int8
from threewe.cli import app
from typer.testing import CliRunner

from verify.cases import act_checkpoints

NAMES = {"rate": 10, "rename": {"action": ["vx", "vy", "omega"], "observation.state": ["vx", "vy", "omega"]}}
ACT = act_checkpoints.Shape(64, 64)


def command(*words: object) -> str:
    result = CliRunner().invoke(app, [str(word) for word in words])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    assert result.exit_code == 0, result.output
    return result.output


def feeds_for(runner: VLARunner, count: int = 12) -> list[dict[str, Any]]:
    random = np.random.default_rng(0)
    shapes = runner.policy.inputs()
    return [{name: random.random(shape, np.float32) for name, shape in shapes.items()} for _ in range(count)]


def test_int8_gives_nearly_the_same_actions(tmp_path: Path) -> None:
    runner = VLARunner.from_pretrained("goto_v1")
    feeds = calibration_feeds(runner, None, 24)
    path = list(sys.path)
    write_int8(runner.policy, feeds, tmp_path / "int8")
    assert sys.path == path, "a user's own module named `benchmark` is found as before"
    eight = VLARunner.from_pretrained(tmp_path / "int8")
    assert eight.policy == replace(runner.policy, folder=tmp_path / "int8", training=eight.policy.training)
    assert eight.policy.graph.stat().st_size < 0.35 * runner.policy.graph.stat().st_size
    full, less = (np.concatenate([each._engine.infer(feed, "") for feed in feeds]) for each in (runner, eight))
    assert np.abs(full - less).mean() < 0.1 * full.std()
    with pytest.raises(ConfigError, match="exists already"):
        write_int8(runner.policy, feeds, tmp_path / "int8")
    with pytest.raises(ConfigError, match="eight bits already"):
        write_int8(eight.policy, feeds, tmp_path / "again")


def test_an_act_is_cut_at_its_backbone_and_runs_on_a_played_hailo(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = VLARunner.from_pretrained(act_checkpoints.write(tmp_path / "act", ACT), **NAMES)
    feeds = feeds_for(whole)
    write_for_hailo(whole.policy, feeds, tmp_path / "hailo", "hailo8l")
    names = {path.name for path in (tmp_path / "hailo").iterdir()}
    assert names == {"encoder.onnx", "encoder.alls", "calibration.npy", "compile.sh", "policy"}
    pictures = np.load(tmp_path / "hailo/calibration.npy")
    assert (pictures.shape, pictures.dtype) == ((12, 64, 64, 3), np.uint8)
    encoder = onnx.load(str(tmp_path / "hailo/encoder.onnx")).graph
    assert {node.op_type for node in encoder.node} <= {"Conv", "Relu", "MaxPool", "Add"}
    assert sum(node.op_type == "Conv" for node in encoder.node) == 21  # ResNet-18 and the projection
    with pytest.raises(ConfigError, match=r"encoder\.hef"):
        VLARunner.from_pretrained(tmp_path / "hailo/policy")

    hailort.compile_encoder(tmp_path / "hailo")
    monkeypatch.setenv("THREEWE_HAILORT", str(hailort.build(tmp_path)))
    cut = VLARunner.from_pretrained(tmp_path / "hailo/policy")
    for feed in feeds:
        pixels = {name: np.rint(v * 255) / 255 if v.ndim == 4 else v for name, v in feed.items()}
        np.testing.assert_allclose(cut._engine.infer(pixels, ""), whole._engine.infer(pixels, ""), atol=2e-4)

    with pytest.raises(HardwareError, match="HAILO_OUT_OF_PHYSICAL_DEVICES"):
        VLARunner.from_pretrained(tmp_path / "hailo/policy")
    del cut
    cut = VLARunner.from_pretrained(tmp_path / "hailo/policy")

    async def drive() -> str:
        async with Robot(image_size=(64, 64)) as robot:
            return (await cut.run(robot, "go to the chair", timeout=1.0)).reason

    assert asyncio.run(drive()) in ("timeout", "reached")
    monkeypatch.setenv("PLAYED_HAILORT_HANGS", "1")
    with pytest.raises(HardwareError, match="HAILO_TIMEOUT"):
        cut._engine.infer(feeds[0], "")
    assert asyncio.run(drive()) == "policy_error"


def test_without_hailort_one_sentence_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = VLARunner.from_pretrained(act_checkpoints.write(tmp_path / "act", ACT), **NAMES)
    write_for_hailo(whole.policy, feeds_for(whole, 2), tmp_path / "hailo", "hailo8l")
    hailort.compile_encoder(tmp_path / "hailo")
    policy = tmp_path / "hailo/policy"
    monkeypatch.delenv("THREEWE_HAILORT", raising=False)
    monkeypatch.setattr("threewe.ai.hailo.find_library", lambda _: None)
    with pytest.raises(ConfigError, match=r"needs HailoRT 4\.x.*libhailort\.so is not installed here"):
        VLARunner.from_pretrained(policy)
    monkeypatch.setenv("THREEWE_HAILORT", str(tmp_path / "none.so"))
    with pytest.raises(ConfigError, match=r"needs HailoRT 4\.x.*none\.so"):
        VLARunner.from_pretrained(policy)
    monkeypatch.setenv("THREEWE_HAILORT", str(hailort.build(tmp_path)))
    monkeypatch.setenv("PLAYED_HAILORT_MAJOR", "5")
    with pytest.raises(ConfigError, match=r"is 5\.20\.0"):
        VLARunner.from_pretrained(policy)
    monkeypatch.delenv("PLAYED_HAILORT_MAJOR")
    (policy / "encoder.hef").write_bytes(b"\x01HEF and then nothing")
    with pytest.raises(HardwareError, match="HAILO_INVALID_HEF"):
        VLARunner.from_pretrained(policy)
    (policy / "encoder.hef").write_bytes(b"something else")
    with pytest.raises(ConfigError, match=r"encoder\.hef: not what Hailo's compiler writes"):
        VLARunner.from_pretrained(policy)


def test_what_cannot_be_cut_is_refused(tmp_path: Path) -> None:
    shipped = VLARunner.from_pretrained("goto_v1")
    with pytest.raises(ConfigError, match=r"% of its convolutions see the picture alone"):
        write_for_hailo(shipped.policy, [], tmp_path / "hailo", "hailo8l")
    two = act_checkpoints.Shape(64, 64, cameras=("front", "side"))
    runner = VLARunner.from_pretrained(act_checkpoints.write(tmp_path / "act", two), **NAMES)
    with pytest.raises(ConfigError, match="2 cameras"):
        write_for_hailo(runner.policy, [], tmp_path / "hailo", "hailo8l")
    assert not (tmp_path / "hailo").exists()


def test_the_command_exports_and_says_where(tmp_path: Path) -> None:
    output = command("policy", "export", "goto_v1", "--int8", "--count", "10", "-o", tmp_path / "int8")
    assert str(tmp_path / "int8") in output.replace("\n", "")
    for words in ([], ["--int8", "--hailo", tmp_path / "hailo"]):
        with pytest.raises(ConfigError, match="say --int8, or --hailo DIR"):
            command("policy", "export", "goto_v1", *words)
    with pytest.raises(ConfigError, match="no LeRobot dataset"):
        command("policy", "export", "goto_v1", "--int8", "--dataset", tmp_path, "-o", tmp_path / "other")


def test_convert_writes_a_folder_that_needs_no_names(tmp_path: Path) -> None:
    checkpoint = act_checkpoints.write(tmp_path / "act", ACT)
    named = ("--rename", "action=vx,vy,omega", "--rename", "observation.state=vx,vy,omega")
    command("policy", "convert", checkpoint, "-o", tmp_path / "policy", "--rate", 10, *named)
    ours, theirs = VLARunner.from_pretrained(tmp_path / "policy"), VLARunner.from_pretrained(checkpoint, **NAMES)
    assert {path.name for path in (tmp_path / "policy").iterdir()} == {"policy.json", "model.onnx"}
    for feed in feeds_for(ours, 3):
        np.testing.assert_array_equal(ours._engine.infer(feed, ""), theirs._engine.infer(feed, ""))
    with pytest.raises(ConfigError, match="exists already"):
        command("policy", "convert", checkpoint, "-o", tmp_path / "policy")
    output = command("policy", "export", tmp_path / "policy", "--hailo", tmp_path / "hailo", "--count", "10")
    assert f"{tmp_path / 'hailo/compile.sh'} compiles" in output.replace("\n", " ")
    pictures = np.load(tmp_path / "hailo/calibration.npy")
    assert (pictures.shape, pictures.std() > 10) == ((10, 64, 64, 3), True)
    with pytest.raises(ConfigError, match=r"no checkpoint of LeRobot, which has config\.json"):
        command("policy", "convert", tmp_path / "policy", "-o", tmp_path / "other")
    with pytest.raises(ConfigError, match=r"'front' is no THEIRS=OURS"):
        command("policy", "convert", checkpoint, "-o", tmp_path / "other", "--rename", "front")
    with pytest.raises(ConfigError, match="says no rate"):
        command("policy", "convert", checkpoint, "-o", tmp_path / "other", *named)


def test_a_policy_of_stages_is_checked_as_any_other(tmp_path: Path) -> None:
    folder = policies.write(tmp_path / "policy", features=[4, 0, 1])
    with pytest.raises(ConfigError, match=r"policy\.json: features: must be \[channels, height, width\]"):
        read_policy(folder)
    folder = policies.write(tmp_path / "policy", features=[4, 1, 1])
    with pytest.raises(ConfigError, match=r"head\.onnx"):
        read_policy(folder)
    shutil.copy(folder / "model.onnx", folder / "head.onnx")
    (folder / "encoder.hef").write_bytes(b"\x01HEF")
    with pytest.raises(ConfigError, match=r"head\.onnx: inputs do not fit policy\.json.*features"):
        read_policy(folder)
    plain = read_policy(policies.write(tmp_path / "plain"))
    write_policy(replace(plain, folder=tmp_path / "same"), plain.graph.read_bytes())
    assert read_policy(tmp_path / "same") == replace(plain, folder=tmp_path / "same")


def test_bench_writes_the_latency_that_simulation_charges(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = policies.write(tmp_path / "policy", latency=1.5)
    command("policy", "bench", folder, "--count", "3")
    assert read_policy(folder).latency == 1.5
    output = command("policy", "bench", folder, "--count", "3", "--write")
    written = read_policy(folder)
    assert 0.0 < written.latency < 1.5
    assert written.latency / 0.02 == pytest.approx(round(written.latency / 0.02))
    assert f"latency 1.5 s is {written.latency:g} s now" in output
    monkeypatch.setattr("threewe.ai.cli.LONGEST_LATENCY", 0.001)
    with pytest.raises(ConfigError, match="more than a latency may be"):
        command("policy", "bench", folder, "--count", "3", "--write")
