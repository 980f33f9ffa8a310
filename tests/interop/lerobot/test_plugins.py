"""LeRobot's own commands on our environment and our robot, which it finds by their names."""

from __future__ import annotations

import asyncio
import base64
import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
from threewe.ai import VLARunner, read_policy
from threewe.ai.agent import PolicyAgent
from threewe.ai.collecting import Collection, collect_demonstrations
from threewe.ai.demonstrations import PICTURE
from threewe.ai.demonstrations import demonstrations as demonstrations_in
from threewe.ai.evaluating import Evaluation, episodes_of
from threewe.ai.loading import convert_checkpoint
from threewe.ai.training import train_policy
from threewe.benchmark.attempt import Settings, attempt_with
from threewe.data.lerobot import Dataset

from tests.interop.lerobot.asking import peer_of
from tests.interop.lerobot.test_policies import theirs as chunks_of
from verify.cases.act_checkpoints import TEXT, Shape

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
    require_alike(theirs, drive_here(tmp_path / "policy"), least=1)
    require_the_same_actions(checkpoint, demonstrations)


def require_alike(theirs: list[bool], ours: list[bool], least: int) -> None:
    """The same successes, in most of the episodes, and some: LeRobot plays an action when it has its picture, we at
    its time."""
    alike = sum(a == b for a, b in zip(theirs, ours, strict=True))
    print(f"successes: {sum(theirs)} of LeRobot's, {sum(ours)} of ours; the same in {alike} of {EPISODES}")
    assert alike >= 0.9 * EPISODES  # all of them, when it was last seen
    assert min(sum(theirs), sum(ours)) >= least


def drive_here(policy: str | Path) -> list[bool]:
    """The successes in the episodes of LeRobot's environment, as `threewe policy eval` drives them."""
    episodes = episodes_of(Evaluation("generated", count=EPISODES), 0)
    tried = [attempt_with("objectnav", one, PolicyAgent(policy, latency=0.0), Settings()) for one in episodes]
    return [each["metrics"]["success"] > 0.5 for each in tried]


def require_the_same_actions(checkpoint: Path, dataset: Path) -> None:
    """By LeRobot, our loader and LeRobot as our child, for what a dataset shows: by the range of LeRobot's own."""
    rows = demonstrations_in([Dataset.open(dataset)], 10)
    some = np.linspace(0, len(rows.pictures) - 1, 100).astype(int)
    pictures = (rows.pictures[some].astype(np.float32) / 255).transpose(0, 3, 1, 2)
    given = [{PICTURE: pictures[i : i + 1], TEXT: rows.embeddings[row : row + 1]} for i, row in enumerate(some)]
    with peer_of("policies_peer.py") as lerobot:
        expected = chunks_of(lerobot, checkpoint, given)
    own = np.ptp(expected, (0, 1))
    for how, options in (("our loader", {}), ("the child", {"python": PYTHON})):
        runner = VLARunner.from_pretrained(checkpoint, dataset=dataset, **options)
        found = np.array([runner._engine.infer(each, "")[0] for each in given])
        difference = (np.abs(found - expected).max((0, 1)) / own).max()
        print(f"{how}: differs by {difference:.1e} of the range, which is {own}")
        assert difference <= 1e-5


def test_a_policy_that_succeeds_does_so_in_lerobots_environment_too() -> None:
    runner = VLARunner.from_pretrained("goto_v1")
    theirs = []
    with peer_of("env_peer.py") as lerobot:
        for episode in range(EPISODES):
            seen = lerobot("reset", episode=episode)
            while not seen["over"]:
                picture = np.frombuffer(base64.b64decode(seen["picture"]), np.uint8).reshape(seen["shape"])
                action = runner.predict(np.ascontiguousarray(picture[:, :, ::-1]), seen["task"])
                seen = lerobot("step", action=action.tolist())
            theirs.append(seen["success"])
    require_alike(theirs, drive_here("goto_v1"), least=12)  # 17 and 17


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


@pytest.mark.parametrize("backend", ["mock", "mujoco"])
def test_lerobot_record_writes_a_dataset_of_our_robot(tmp_path: Path, backend: str) -> None:
    command(
        "lerobot-record",
        "--robot.type=threewe",
        "--robot.id=ours",
        f"--robot.backend={backend}",
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
    driven = episode.columns()["observation.state"]
    assert np.abs(driven[-1] - [0.2, 0.0, 0.5]).max() < 0.1  # the circle
    learnt = tmp_path / "policy"
    train_policy([tmp_path / "recorded"], learnt, 1, 1, 0, print)
    assert read_policy(learnt).action[0].mean == pytest.approx(0.2, abs=0.05)
