"""From demonstrations to a policy that drives, by the commands that users type."""

from __future__ import annotations

import asyncio
import json
from pathlib import Path

import numpy as np
import pytest
from threewe import ConfigError, Robot
from threewe.ai import VLARunner, read_policy
from threewe.cli import app
from threewe.data.lerobot import Dataset
from typer.testing import CliRunner


def threewe(*arguments: str) -> str:
    result = CliRunner().invoke(app, arguments)
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result.output


@pytest.fixture(scope="module")
def demos(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("collected") / "demos"
    said = threewe("data", "collect", "--episodes", "4", "--scene", "office_v2", "-o", str(folder))
    assert "of 4 arrived" in said
    return folder


def test_demonstrations_say_what_is_to_be_done(demos: Path) -> None:
    dataset = Dataset.open(demos)
    assert len(dataset) == 4
    assert all(task.startswith("go to the ") for task in dataset.tasks)
    columns = dataset.episodes[0].columns()
    embedding = columns["observation.environment_state"]
    assert embedding.shape == (len(dataset.episodes[0]), 64)
    assert np.linalg.norm(embedding, axis=1) == pytest.approx(1.0)
    assert dataset.episodes[0].video("observation.images.camera").shape == (48, 64, 3)
    assert not columns["action"][-2:].any()  # the robot stands in the end


def test_training_makes_a_policy_that_drives(demos: Path, tmp_path: Path) -> None:
    folder = tmp_path / "policy"
    losses = [
        float(line.split("loss ")[1].split(",")[0])
        for line in threewe("policy", "train", str(demos), "-o", str(folder), "--passes", "3").splitlines()
        if "loss" in line
    ]
    assert losses[-1] < losses[0]
    policy = read_policy(folder)
    assert (policy.chunk, policy.rate, policy.language) == (10, 10.0, True)
    assert (folder / "model.onnx").stat().st_size < 2e6
    assert "48 x 64, rgb" in threewe("policy", "info", str(folder))
    assert "Hz, on one thread" in threewe("policy", "bench", str(folder), "--count", "5")

    async def drive() -> str:
        async with Robot(image_size=(48, 64), seed=5) as robot:
            return (await VLARunner(policy).run(robot, "go to the chair", timeout=3.0)).reason

    assert asyncio.run(drive()) in ("reached", "timeout")
    with pytest.raises(ConfigError, match="exists already"):
        threewe("policy", "train", str(demos), "-o", str(folder))


def test_the_graph_computes_what_the_network_does(tmp_path: Path) -> None:
    import torch
    from ai import policies
    from threewe.ai.network import Network, to_onnx
    from threewe.ai.training import write_policy

    read = read_policy(policies.write(tmp_path / "like"))
    torch.manual_seed(3)
    network = Network(policies.HEIGHT, policies.WIDTH, policies.CHUNK, 3).eval()
    assert sum(each.numel() for each in network.parameters()) <= 500_000
    folder = tmp_path / "policy"
    write_policy(policies.moved(read, folder), to_onnx(network, read))
    runner = VLARunner.from_pretrained(folder)
    random = np.random.default_rng(1)
    for _ in range(20):
        picture = random.integers(0, 256, (policies.HEIGHT, policies.WIDTH, 3), np.uint8)
        rgb = torch.from_numpy(picture[:, :, ::-1].copy()).permute(2, 0, 1)[None].float() / 255
        with torch.no_grad():
            expected = network(rgb, torch.from_numpy(runner._embedding("go to the chair")))[0].numpy()
        assert runner.predict_chunk(picture, "go to the chair") == pytest.approx(expected, abs=1e-5)


def test_datasets_that_cannot_be_learnt_from(demos: Path, tmp_path: Path) -> None:
    from threewe.ai.training import train_policy

    def train(dataset: Path) -> None:
        train_policy(dataset, tmp_path / "policy", 1, 0, print)

    with pytest.raises(ConfigError, match="no LeRobot dataset"):
        train(tmp_path)
    info = json.loads((demos / "meta/info.json").read_text())
    for feature, message in (
        ("observation.images.camera", "no 'observation.images.camera'; there are action"),
        ("observation.environment_state", "no 'observation.environment_state'"),
    ):
        broken = {**info, "features": {name: f for name, f in info["features"].items() if name != feature}}
        copy = tmp_path / feature
        (copy / "meta").mkdir(parents=True)
        for file in (demos / "meta").rglob("*"):
            if file.is_file():
                target = copy / file.relative_to(demos)
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_bytes(file.read_bytes())
        (copy / "meta/info.json").write_text(json.dumps(broken))
        with pytest.raises(ConfigError, match=message):
            train(copy)
    assert not (tmp_path / "policy").exists()
