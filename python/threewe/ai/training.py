"""Training of a policy from demonstrations: a LeRobot dataset in, a folder out that `VLARunner` loads."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn

from threewe._core import RobotProfile
from threewe.ai.folder import DESCRIPTION, GRAPH, VERSION, CameraInput, Policy, Quantity, image_input
from threewe.ai.network import Network, to_onnx
from threewe.data.lerobot import Dataset
from threewe.errors import ConfigError

NAMES = {"vx": "m/s", "vy": "m/s", "omega": "rad/s"}
CAMERA = image_input("camera")
EMBEDDINGS = "observation.environment_state"
SECONDS = 1.0  # of a chunk
CAMERA_DELAY = 0.1  # [s] before a row, its picture was measured: transport 0.08 s, and half a picture's period
LATENCY = 0.1  # [s] that simulation charges for an inference
MOST_HEIGHT = 64  # [px] pictures are made smaller until they are no higher
BATCH = 64
RATE = 1e-3  # at most, of AdamW
DECAY = 0.01
HELD_OUT = 0.1  # of the episodes
LEAST_STD = 0.05  # [m/s], [rad/s] of an action that hardly changes


@dataclass
class Demonstrations:
    """Rows of a dataset, one beside the other."""

    pictures: NDArray[np.uint8]
    """(rows, H, W, 3) RGB"""
    embeddings: NDArray[np.float32]
    """(rows, 64)"""
    actions: NDArray[np.float32]
    """(rows, chunk, numbers) [m/s, rad/s]"""
    held_out: NDArray[np.bool_]
    """(rows,) of episodes that are not learnt from"""


def train_policy(dataset: Path, output: Path, passes: int, seed: int, progress: Callable[[str], object]) -> None:
    """Learns from a dataset's episodes that are no failures, and writes the policy's folder. Raises ConfigError."""
    if output.exists():
        raise ConfigError(f"output: {output} exists already")
    source = Dataset.open(dataset)
    numbers = _check(source)
    chunk = max(2, round(SECONDS * source.fps))
    data = demonstrations(source, chunk)
    progress(f"{len(data.pictures)} rows of {len(source)} episodes, {int(data.held_out.sum())} of them held out")
    policy = _policy_of(source, output, data, numbers, chunk)
    network = _learn(data, policy, passes, seed, progress)
    write_policy(policy, to_onnx(network, policy))


def _check(dataset: Dataset) -> list[str]:
    """The names of an action's numbers. Raises ConfigError for what cannot be learnt from."""
    for name in (CAMERA, EMBEDDINGS, "action"):
        if name not in dataset.features:
            raise ConfigError(f"{dataset.root}: no '{name}'; there are {', '.join(sorted(dataset.own_features))}")
    names = list(dataset.features["action"].names or [])
    if not names or not set(names) <= NAMES.keys():
        raise ConfigError(f"{dataset.root}: action is ({', '.join(map(str, names))}); expected (vx, vy, omega)")
    return [str(name) for name in names]


def demonstrations(dataset: Dataset, chunk: int) -> Demonstrations:
    """All rows. The actions of a row are those from its picture's time on, and zero beyond the episode's end."""
    earlier = round(CAMERA_DELAY * dataset.fps)
    pictures, embeddings, actions, held_out = [], [], [], []
    every = max(2, round(1 / HELD_OUT))
    for episode in dataset.episodes:
        columns = episode.columns()
        if "next.success" in columns and not columns["next.success"].any():
            continue
        video, action = episode.video(CAMERA), columns["action"].astype(np.float32)
        padded = np.concatenate([np.repeat(action[:1], earlier, 0), action, np.zeros((chunk, action.shape[1]))])
        for row in range(len(episode)):
            pictures.append(_smaller(video.image(row)))
            actions.append(padded[row : row + chunk])
        embeddings.append(columns[EMBEDDINGS].astype(np.float32))
        held_out.append(np.full(len(episode), episode.index % every == every - 1))
    if not pictures:
        raise ConfigError(f"{dataset.root}: no episode that succeeded")
    wide = np.stack(actions).astype(np.float32)
    return Demonstrations(np.stack(pictures), np.concatenate(embeddings), wide, np.concatenate(held_out))


def _smaller(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """The mean of n x n pixels each, n the least that makes it low enough."""
    height, width, _ = picture.shape
    n = next(n for n in range(1, height + 1) if height // n <= MOST_HEIGHT and height % n == width % n == 0)
    means = picture.reshape(height // n, n, width // n, n, 3).mean((1, 3))
    return np.asarray(means.round(), np.uint8)


def _policy_of(source: Dataset, output: Path, data: Demonstrations, names: list[str], chunk: int) -> Policy:
    learnt = data.actions[~data.held_out].reshape(-1, len(names))
    kinematics = RobotProfile.load(source.info.robot_type or "3we_standard_v2").kinematics
    _, height, width, _ = data.pictures.shape
    return Policy(
        folder=output,
        kinematics=kinematics,
        cameras=(CameraInput("camera", height, width, "rgb"),),
        state=(),
        action=tuple(
            Quantity(name, NAMES[name], float(learnt[:, i].mean()), max(LEAST_STD, float(learnt[:, i].std())))
            for i, name in enumerate(names)
            if not (name == "vy" and kinematics.name == "differential")
        ),
        rate=float(source.fps),
        chunk=chunk,
        latency=LATENCY,
        merge="blend",
        language=True,
        training={"dataset": source.root.name, "episodes": str(len(source)), "robot": str(source.info.robot_type)},
    )


def _learn(data: Demonstrations, policy: Policy, passes: int, seed: int, progress: Callable[[str], object]) -> Network:
    """The same seed repeats it on one machine."""
    torch.set_num_threads(1)  # layers this small wait for one another on more, and the order of sums would differ
    torch.manual_seed(seed)
    random = np.random.default_rng(seed)
    kept = [list(NAMES).index(q.name) for q in policy.action] if data.actions.shape[2] == 3 else slice(None)
    mean = np.array([q.mean for q in policy.action], np.float32)
    std = np.array([q.std for q in policy.action], np.float32)
    targets = torch.from_numpy((data.actions[:, :, kept] - mean) / std)
    pictures = torch.from_numpy(data.pictures).permute(0, 3, 1, 2)
    embeddings = torch.from_numpy(data.embeddings)
    learnt, held_out = np.flatnonzero(~data.held_out), np.flatnonzero(data.held_out)
    network: Network = Network(policy.cameras[0].height, policy.cameras[0].width, policy.chunk, len(policy.action))
    optimizer = torch.optim.AdamW(network.parameters(), lr=RATE, weight_decay=DECAY)
    steps = passes * -(-len(learnt) // BATCH)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, RATE, total_steps=steps)

    def loss_of(rows: NDArray[np.int64], gain: float) -> torch.Tensor:
        light = (pictures[rows].float() / 255 * gain).clamp(0, 1)
        return nn.functional.smooth_l1_loss(network(light, embeddings[rows]), targets[rows])

    for done in range(passes):
        losses = []
        order = random.permutation(learnt)
        for begin in range(0, len(order), BATCH):
            loss = loss_of(order[begin : begin + BATCH], float(random.uniform(0.8, 1.2)))
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            schedule.step()
            losses.append(loss.item())
        text = f"pass {done + 1} of {passes}: loss {np.mean(losses):.4f}"
        if len(held_out):
            with torch.no_grad():
                text += f", held out {np.mean([loss_of(rows, 1.0).item() for rows in _parts(held_out)]):.4f}"
        progress(text)
    network.eval()
    return network


def _parts(rows: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    return np.array_split(rows, -(-len(rows) // 256))


def write_policy(policy: Policy, graph: bytes) -> None:
    """Writes a policy's folder; it has its name when all of it is there."""
    partial = policy.folder.with_name(f".{policy.folder.name}.partial")
    partial.mkdir(parents=True, exist_ok=True)
    content = {"format": "3we-policy", "version": VERSION, **asdict(policy), "kinematics": policy.kinematics.name}
    del content["folder"]
    (partial / DESCRIPTION).write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
    (partial / GRAPH).write_bytes(graph)
    partial.rename(policy.folder)
