"""LeRobot's own commands on our environment and our robot, which it finds by their names."""

from __future__ import annotations

import asyncio
import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
from threewe.ai.agent import PolicyAgent
from threewe.ai.collecting import Collection, collect_demonstrations
from threewe.ai.evaluating import Evaluation, episodes_of
from threewe.ai.loading import convert_checkpoint
from threewe.benchmark.attempt import Settings, attempt_with
from threewe.data.lerobot import Dataset

from tests.interop.lerobot.asking import peer_of
from verify.cases.act_checkpoints import Shape

PYTHON = Path(os.environ["LEROBOT_PYTHON"])
EPISODES = 20
STEPS = 300


def command(name: str, *options: str) -> str:
    env = {**os.environ, "HF_HUB_OFFLINE": "1", "HF_HUB_DISABLE_TELEMETRY": "1", "OMP_NUM_THREADS": "1"}
    done = subprocess.run([PYTHON.parent / name, *options], capture_output=True, text=True, env=env)
    assert done.returncode == 0, done.stderr[-3000:]
    return done.stdout + done.stderr


@pytest.fixture(scope="module")
def demonstrations(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("data") / "demos"
    asyncio.run(collect_demonstrations(folder, 24, Collection(seed=5)))
    return folder


def test_lerobot_trains_an_act_and_evaluates_it_as_we_do(demonstrations: Path, tmp_path: Path) -> None:
    act = ["--policy.type=act", "--policy.pretrained_backbone_weights=null", "--policy.device=cpu"]
    small = ["--policy.chunk_size=10", "--policy.n_action_steps=1", "--policy.dim_model=128", "--policy.n_heads=4"]
    picture, text = "{type: VISUAL, shape: [3, 60, 80]}", "{type: ENV, shape: [64]}"
    inputs = f"{{observation.images.camera: {picture}, observation.environment_state: {text}}}"
    said = command(
        "lerobot-train",
        *act,
        *small,
        "--policy.dim_feedforward=256",
        f"--policy.input_features={inputs}",
        "--policy.push_to_hub=false",
        f"--dataset.root={demonstrations}",
        "--dataset.repo_id=local/demos",
        f"--output_dir={tmp_path / 'out'}",
        f"--steps={STEPS}",
        f"--save_freq={STEPS}",
        "--log_freq=50",
        "--batch_size=8",
        "--num_workers=0",
        "--wandb.enable=false",
    )
    losses = [float(word[5:]) for word in said.split() if word.startswith("loss:")]
    print("loss", losses)
    assert losses[-1] < losses[0]
    checkpoint = tmp_path / "out/checkpoints/last/pretrained_model"

    command(
        "lerobot-eval",
        f"--policy.path={checkpoint}",
        "--policy.device=cpu",
        "--env.type=threewe",
        f"--env.count={EPISODES}",
        "--seed=0",
        f"--eval.n_episodes={EPISODES}",
        "--eval.batch_size=1",
        f"--output_dir={tmp_path / 'eval'}",
    )
    found = json.loads((tmp_path / "eval/eval_info.json").read_text())
    theirs = [bool(each) for task in found["per_task"] for each in task["metrics"]["successes"]]
    convert_checkpoint(checkpoint, tmp_path / "policy", dataset=demonstrations)
    ours = []
    for episode in episodes_of(Evaluation("generated", count=EPISODES), 0):
        tried = attempt_with("objectnav", episode, PolicyAgent(tmp_path / "policy", latency=0.0), Settings())
        ours.append(tried["metrics"]["success"] > 0.5)
    alike = sum(a == b for a, b in zip(theirs, ours, strict=True))
    print(f"successes: {sum(theirs)} of LeRobot's, {sum(ours)} of ours; the same in {alike} of {EPISODES}")
    assert alike >= 0.8 * EPISODES  # LeRobot plays an action when it has its picture, we at its time


def test_lerobot_drives_our_robot_and_sees_colors(tmp_path: Path) -> None:
    program = Path(__file__).with_name("plugins_peer.py")
    done = subprocess.run([PYTHON, program], capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stderr[-3000:]
    assert done.stdout.splitlines()[-3:] == ["driven", "red", "wood"]


def test_lerobot_rollout_drives_our_robot(tmp_path: Path) -> None:
    shape = Shape(60, 80, text=False)
    with peer_of("policies_peer.py") as lerobot:
        options = {"pretrained_backbone_weights": None, "chunk_size": 10, "n_action_steps": 1, "dim_model": 64}
        inputs = shape.config()["input_features"]
        root = tmp_path / "act"
        lerobot("train", root=root, kind="act", options=options, inputs=inputs, numbers=3, steps=2)
    said = command(
        "lerobot-rollout",
        "--strategy.type=sentry",
        f"--policy.path={root}",
        "--policy.device=cpu",
        "--robot.type=threewe",
        "--robot.id=ours",
        "--robot.image_size=[60, 80]",
        "--task=drive",
        "--fps=5",
        "--duration=6",
        "--return_to_initial_position=false",
        "--play_sounds=false",
        "--dataset.repo_id=local/rollout_ours",
        f"--dataset.root={tmp_path / 'rollout'}",
        "--dataset.single_task=drive",
        "--dataset.push_to_hub=false",
    )
    (dataset,) = [Dataset.open(path.parent.parent) for path in tmp_path.glob("**/meta/info.json")]
    rows = sum(map(len, dataset.episodes))
    driven = np.concatenate([episode.columns()["observation.state"] for episode in dataset.episodes])
    print(f"{rows} rows, up to {driven[:, 0].max():.2f} m/s", said[-300:])
    assert rows >= 5
    wanted = np.concatenate([episode.columns()["action"] for episode in dataset.episodes])
    assert np.abs(wanted).max() > 0.02  # what the policy says reaches the robot, and it moves
    assert np.abs(driven).max() > 0.02


def test_lerobot_record_writes_a_dataset_of_our_robot(tmp_path: Path) -> None:
    command(
        "lerobot-record",
        "--robot.type=threewe",
        "--robot.id=ours",
        "--robot.image_size=[60, 80]",
        "--teleop.type=circle",
        "--dataset.repo_id=local/recorded",
        f"--dataset.root={tmp_path / 'recorded'}",
        "--dataset.single_task=drive a circle",
        "--dataset.num_episodes=1",
        "--dataset.episode_time_s=3",
        "--dataset.reset_time_s=0",
        "--dataset.fps=10",
        "--dataset.push_to_hub=false",
        "--play_sounds=false",
    )
    dataset = Dataset.open(tmp_path / "recorded")
    (episode,) = dataset.episodes
    assert len(episode) >= 15
    assert dataset.features["action"].names == ["vx.vel", "vy.vel", "omega.vel"]
