"""Training of a policy from demonstrations: a LeRobot dataset in, a folder out that `VLARunner` loads.

Two models: a FiLM network, and LeRobot's ACT, whose folder LeRobot loads, too.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, TypeAlias

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn
from torch.optim.swa_utils import AveragedModel

from threewe._core import RobotProfile
from threewe.ai.act_network import ActNetwork, act_files, act_to_onnx
from threewe.ai.folder import ACTION, CAMERA, EMBEDDED, CameraInput, Policy, Quantity, image_input, write_policy
from threewe.ai.naming import LATENCY
from threewe.ai.network import Network, to_onnx
from threewe.ai.runner import AGE
from threewe.data.lerobot import Dataset
from threewe.data.lerobot.editing import require_alike
from threewe.data.recording import DISTURBED
from threewe.errors import ConfigError

NAMES = {"vx": "m/s", "vy": "m/s", "omega": "rad/s"}
PICTURE = image_input(CAMERA)
SECONDS = 1.0  # of a chunk
CAMERA_DELAY = 0.1  # [s] before a row, its picture was measured: transport 0.08 s, and half a picture's period
MOST_HEIGHT = 64  # [px] pictures are made smaller until they are no higher
BATCH = 64
RATES = {"film": 1e-3, "act": 3e-4}  # at most, of AdamW
DECAY = 0.01
HELD_OUT = 0.1  # of the episodes
LEAST_STD = 0.05  # [m/s], [rad/s] of an action that hardly changes
AVERAGED = 0.999  # of the mean of the weights before, in the mean with those of a step
GAIN, TINT, NOISE = 0.3, 0.1, 0.06  # by which pictures differ: of all, of each channel, of each pixel
CHECK_SEED = 20_261_130  # of the buildings in which checkpoints drive


@dataclass
class Demonstrations:
    """Rows of a dataset, one beside the other."""

    pictures: NDArray[np.uint8]
    """(rows, H, W, 3) RGB"""
    embeddings: NDArray[np.float32]
    """(rows, 64)"""
    actions: NDArray[np.float32]
    """(rows, chunk, numbers) [m/s, rad/s]"""
    wanted: NDArray[np.bool_]
    """(rows, chunk) actions of the teacher's: none once random commands have pushed the robot since the picture"""
    held_out: NDArray[np.bool_]
    """(rows,) of episodes that are not learnt from"""


def train_policy(
    datasets: Sequence[Path],
    output: Path,
    passes: int,
    seed: int,
    checks: int,
    progress: Callable[[str], object],
    model: str = "film",
    prefix: bool = False,
) -> None:
    """Learns from datasets' episodes that are no failures, and writes the policy's folder. Raises ConfigError.

    With the model `act` LeRobot's files are in it, too. With a `prefix` the policy learns to go on from actions that
    are committed already. After each pass of the later half the policy drives in `checks`
    generated buildings, and the best one is kept; with none the last.
    """
    if output.exists():
        raise ConfigError(f"output: {output} exists already")
    if prefix and model != "film":
        raise ConfigError("prefix: LeRobot's ACT takes none; leave it out, or train the model film")
    sources = [Dataset.open(dataset) for dataset in datasets]
    numbers = _check(sources[0])
    for other in sources[1:]:
        require_alike(sources[0], other)
    chunk = max(2, round(SECONDS * sources[0].fps))
    data = demonstrations(sources, chunk)
    episodes = sum(map(len, sources))
    progress(f"{len(data.pictures)} rows of {episodes} episodes, {int(data.held_out.sum())} of them held out")
    policy = _policy_of(sources[0], output, data, numbers, chunk)
    if prefix:  # a chunk begins with what is committed, so that there is nothing to blend
        longest = round((LATENCY + AGE) * policy.rate) + 1
        policy = replace(policy, prefix=min(chunk - 1, longest), merge="replace")
    policy.training["dataset"] = ", ".join(source.root.name for source in sources)
    policy.training["episodes"] = str(episodes)
    best: tuple[float, _Files] = -1.0, (policy, b"", {})
    for done, network in enumerate(_learn(data, policy, passes, seed, progress, model), 1):
        if done == passes or (checks and done > passes // 2):
            made = _files_of(network, policy)
            success = _closed_loop(made, checks) if checks else 0.0
            best = max(best, (success, made), key=lambda one: one[0])
            if checks:
                progress(f"pass {done} of {passes}: SR {success:.3f} in {checks} generated buildings")
    if checks:
        policy.training["closed loop"] = f"SR {best[0]:.3f} in {checks} generated buildings, best of the later passes"
    write_policy(*best[1])


_Files: TypeAlias = tuple[Policy, bytes, dict[str, bytes]]
"""A policy, its graph, and other files of its folder by their names."""


def _files_of(network: nn.Module, policy: Policy) -> _Files:
    if isinstance(network, ActNetwork):
        files = act_files(network, policy)
        in_units = replace(policy, action=tuple(replace(each, mean=0.0, std=1.0) for each in policy.action))
        return in_units, act_to_onnx(files, in_units), files
    assert isinstance(network, Network)
    return policy, to_onnx(network, policy), {}


def _closed_loop(made: _Files, count: int) -> float:
    """How often a policy reaches things in generated buildings, which are the same each time."""
    from threewe.ai.evaluating import GENERATED, Evaluation, evaluate

    with TemporaryDirectory() as folder:
        trial = replace(made[0], folder=Path(folder, "policy"))
        write_policy(trial, made[1])
        drives = evaluate(trial.folder, Evaluation(GENERATED, count=count, seeds=(CHECK_SEED,)))
    return float(np.mean([drive.success for drive in drives]))


def _check(dataset: Dataset) -> list[str]:
    """The names of an action's numbers. Raises ConfigError for what cannot be learnt from."""
    for name in (PICTURE, EMBEDDED, ACTION):
        if name not in dataset.features:
            raise ConfigError(f"{dataset.root}: no '{name}'; there are {', '.join(sorted(dataset.own_features))}")
    names = list(dataset.features[ACTION].names or [])
    if not names or not set(names) <= NAMES.keys():
        raise ConfigError(f"{dataset.root}: action is ({', '.join(map(str, names))}); expected (vx, vy, omega)")
    return [str(name) for name in names]


def demonstrations(datasets: Sequence[Dataset], chunk: int) -> Demonstrations:
    """All rows. The actions of a row are those from its picture's time on, and zero beyond the episode's end."""
    earlier = round(CAMERA_DELAY * datasets[0].fps)
    pictures, embeddings, actions, wanted, held_out = [], [], [], [], []
    every = max(2, round(1 / HELD_OUT))
    for episode in [episode for dataset in datasets for episode in dataset.episodes]:
        columns = episode.columns()
        if "next.success" in columns and not columns["next.success"].any():
            continue
        video, action = episode.video(PICTURE), columns[ACTION].astype(np.float32)
        rows = len(episode)
        pictures.append(np.stack([_smaller(video.image(row)) for row in range(rows)]))
        actions.append(_ahead(np.concatenate([np.repeat(action[:1], earlier, 0), action]), rows, chunk))
        pushed = columns[DISTURBED].reshape(-1, 1) if DISTURBED in columns else np.zeros((rows, 1), np.bool_)
        pushed = np.concatenate([np.repeat(pushed[:1], earlier, 0), pushed])
        wanted.append(~np.maximum.accumulate(_ahead(pushed, rows, chunk)[:, :, 0], axis=1))
        embeddings.append(columns[EMBEDDED].astype(np.float32))
        held_out.append(np.full(rows, episode.index % every == every - 1))
    if not pictures:
        raise ConfigError(f"{datasets[0].root}: no episode that succeeded")
    return Demonstrations(
        np.concatenate(pictures),
        np.concatenate(embeddings),
        np.concatenate(actions),
        np.concatenate(wanted),
        np.concatenate(held_out),
    )


def _ahead(values: NDArray[Any], rows: int, chunk: int) -> NDArray[Any]:
    """(rows, chunk, numbers): of each row its own values and those that follow, zero beyond the end."""
    padded = np.concatenate([values, np.zeros((chunk, values.shape[1]), values.dtype)])
    return np.stack([padded[row : row + chunk] for row in range(rows)])


def _smaller(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """The mean of n x n pixels each, n the least that makes it low enough."""
    height, width, _ = picture.shape
    n = next(n for n in range(1, height + 1) if height // n <= MOST_HEIGHT and height % n == width % n == 0)
    means = picture.reshape(height // n, n, width // n, n, 3).mean((1, 3))
    return np.asarray(means.round(), np.uint8)


def _policy_of(source: Dataset, output: Path, data: Demonstrations, names: list[str], chunk: int) -> Policy:
    learnt = data.actions[~data.held_out & data.wanted.all(1)].reshape(-1, len(names))
    kinematics = RobotProfile.load(source.info.robot_type or "3we_standard_v2").kinematics
    _, height, width, _ = data.pictures.shape
    return Policy(
        folder=output,
        kinematics=kinematics,
        cameras=(CameraInput(CAMERA, height, width, "rgb"),),
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
        training={"robot": str(source.info.robot_type)},
    )


def _learn(
    data: Demonstrations, policy: Policy, passes: int, seed: int, progress: Callable[[str], object], model: str
) -> Iterator[nn.Module]:
    """The network after each pass, with the mean of its weights. The same seed repeats it on one machine."""
    torch.set_num_threads(1)  # layers this small wait for one another on more, and the order of sums would differ
    torch.manual_seed(seed)
    random = np.random.default_rng(seed)
    kept = [list(NAMES).index(q.name) for q in policy.action] if data.actions.shape[2] == 3 else slice(None)
    mean = np.array([q.mean for q in policy.action], np.float32)
    std = np.array([q.std for q in policy.action], np.float32)
    targets = torch.from_numpy((data.actions[:, :, kept] - mean) / std)
    wanted = torch.from_numpy(data.wanted.astype(np.float32))[:, :, None]
    pictures = torch.from_numpy(data.pictures).permute(0, 3, 1, 2)  # as it lies in memory: faster, too
    embeddings = torch.from_numpy(data.embeddings)
    usable = data.wanted.any(1)
    learnt, held_out = np.flatnonzero(usable & ~data.held_out), np.flatnonzero(usable & data.held_out)
    network = _network(model, policy, data).to(memory_format=torch.channels_last)
    averaged = AveragedModel(network, avg_fn=_averaged)
    optimizer = torch.optim.AdamW(network.parameters(), lr=RATES[model], weight_decay=DECAY)
    steps = passes * -(-len(learnt) // BATCH)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, RATES[model], total_steps=steps)

    def loss_of(
        model: nn.Module, light: torch.Tensor, rows: NDArray[np.int64], known: NDArray[np.bool_] | None = None
    ) -> torch.Tensor:
        given, counted = [light, embeddings[rows]], wanted[rows]
        if policy.prefix:
            mask = torch.zeros(len(rows), policy.prefix, 1) if known is None else torch.from_numpy(known)[..., None]
            given.append(torch.cat([targets[rows, : policy.prefix] * mask, mask.float()], 2))
            counted = torch.cat([counted[:, : policy.prefix] * (1 - mask.float()), counted[:, policy.prefix :]], 1)
        losses = nn.functional.smooth_l1_loss(model(*given), targets[rows], reduction="none")
        return (losses * counted).sum() / (counted.sum().clamp(min=1) * targets.shape[2])

    for done in range(passes):
        losses = []
        order = random.permutation(learnt)
        for begin in range(0, len(order), BATCH):
            rows = order[begin : begin + BATCH]
            committed = random.integers(policy.prefix + 1, size=(len(rows), 1)) if policy.prefix else None
            known = None if committed is None else np.arange(policy.prefix) < committed
            loss = loss_of(network, _relit(pictures[rows].float() / 255), rows, known)
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            schedule.step()
            averaged.update_parameters(network)
            losses.append(loss.item())
        text = f"pass {done + 1} of {passes}: loss {np.mean(losses):.4f}"
        if len(held_out):
            with torch.no_grad():
                parts = [loss_of(averaged, pictures[rows].float() / 255, rows).item() for rows in _parts(held_out)]
            text += f", held out {np.mean(parts):.4f}"
        progress(text)
        yield averaged.module.eval()


def _network(model: str, policy: Policy, data: Demonstrations) -> nn.Module:
    """One that has learnt nothing."""
    camera, numbers = policy.cameras[0], len(policy.action)
    if model == "film":
        return Network(camera.height, camera.width, policy.chunk, numbers, policy.prefix)
    some = data.pictures[:: max(1, len(data.pictures) // 1000)].reshape(-1, 3) / np.float32(255)
    return ActNetwork(policy.chunk, numbers, some.mean(0), some.std(0))


def _averaged(before: torch.Tensor, now: torch.Tensor, steps: torch.Tensor | int) -> torch.Tensor:
    """The mean of weights, over fewer steps in the beginning."""
    return before + (now - before) * max(1.0 - AVERAGED, 10.0 / (10.0 + float(steps)))


def _relit(pictures: torch.Tensor) -> torch.Tensor:
    """The same pictures (N, 3, H, W) 0 to 1 in other light, by another camera."""
    count = len(pictures)
    gain = 1.0 + GAIN * (2.0 * torch.rand(count, 1, 1, 1) - 1.0)
    tint = 1.0 + TINT * (2.0 * torch.rand(count, 3, 1, 1) - 1.0)
    noise = NOISE * torch.rand(count, 1, 1, 1) * (2.0 * torch.rand_like(pictures) - 1.0)
    return (pictures * gain * tint + noise).clamp(0.0, 1.0)


def _parts(rows: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    return np.array_split(rows, -(-len(rows) // 256))
