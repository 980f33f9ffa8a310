"""Training of a policy from demonstrations: a LeRobot dataset in, a folder out that `VLARunner` loads.

Two models: a FiLM network, and LeRobot's ACT, whose folder LeRobot loads, too.
"""

from __future__ import annotations

import copy
import json
import shutil
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, TypeAlias

import numpy as np
import torch
from numpy.typing import NDArray
from safetensors import SafetensorError, safe_open
from safetensors.torch import load_file, save_file
from torch import nn
from torch.optim.swa_utils import AveragedModel

from threewe._core import Kinematics, RobotProfile
from threewe._device import torch_device
from threewe.ai.act_network import ActNetwork, act_files, act_to_onnx
from threewe.ai.demonstrations import Demonstrations, demonstrations, velocities_of
from threewe.ai.folder import CAMERA, CameraInput, Policy, Quantity, write_policy
from threewe.ai.naming import LATENCY
from threewe.ai.network import Network, to_onnx
from threewe.ai.runner import AGE
from threewe.benchmark.attempt import Settings
from threewe.data.lerobot import Dataset
from threewe.data.lerobot.editing import require_alike
from threewe.errors import ConfigError

SIDES = ("vy", "omega")
"""Actions that a mirror turns round."""
NAMES = {"vx": "m/s", "vy": "m/s", "omega": "rad/s"}
SECONDS = 1.0  # of a chunk
RATES = {"film": 1e-3, "act": 3e-4}  # at most, of AdamW
DECAY = 0.01
LEAST_STD = 0.05  # [m/s], [rad/s] of an action that hardly changes
AVERAGED = 0.999  # of the mean of the weights before, in the mean with those of a step
GAIN, TINT, NOISE = 0.3, 0.1, 0.06  # by which pictures differ: of all, of each channel, of each pixel
CHECK_SEED = 20_261_130  # of the buildings in which checkpoints drive
POINTS = 10  # of the curve of losses, in each pass
CURVES = "losses.csv"
STATE = "state.safetensors"


def train_policy(
    datasets: Sequence[Path],
    output: Path,
    passes: int,
    seed: int,
    checks: int,
    progress: Callable[[str], object],
    model: str = "film",
    prefix: bool = False,
    resume: bool = False,
    *,
    batch_size: int = 64,
    device: str = "cpu",
    mirror: bool = False,
) -> None:
    """Learns from datasets' episodes that are no failures, and writes the policy's folder. Raises ConfigError.

    With the model `act` LeRobot's files are in it, too. With a `prefix` the policy learns to go on from actions that
    are committed already. To `mirror` is to exchange left and right in half of the rows, which is right where the
    camera is in the middle and no task names a side. After each pass of the later half the policy drives in `checks`
    generated buildings, and the best one is kept; with none the last. What a training is at after each pass is in a
    folder beside the output, until that is there: `resume` goes on from it, to the same policy.
    """
    place = torch_device(device)
    if output.exists():
        raise ConfigError(f"output: {output} exists already")
    if prefix and model != "film":
        raise ConfigError("prefix: LeRobot's ACT takes none; leave it out, or train the model film")
    kept = output.with_name(f"{output.name}.training")
    if kept.exists() != resume:
        is_there = "is a training that did not end; --resume goes on with it" if kept.exists() else "is not there"
        raise ConfigError(f"output: {kept} {is_there}")
    sources = [Dataset.open(dataset) for dataset in datasets]
    velocities_of(sources[0])
    for other in sources[1:]:
        require_alike(sources[0], other)
    chunk = max(2, round(SECONDS * sources[0].fps))
    data = demonstrations(sources, chunk)
    episodes = sum(map(len, sources))
    progress(f"{len(data.pictures)} rows of {episodes} episodes, {int(data.held_out.sum())} of them held out")
    policy = _policy_of(sources[0], output, data, chunk)
    if mirror:  # what goes to one side goes as often to the other
        policy = replace(policy, action=tuple(replace(q, mean=0.0) if q.name in SIDES else q for q in policy.action))
    if prefix:  # a chunk begins with what is committed, so that there is nothing to blend
        longest = round((LATENCY + AGE) * policy.rate) + 1
        policy = replace(policy, prefix=min(chunk - 1, longest), merge="replace")
    policy.training["dataset"] = ", ".join(source.root.name for source in sources)
    policy.training["episodes"] = str(episodes)
    if checks and policy.kinematics is not RobotProfile.load(Settings.hardware).kinematics:
        progress(f"no drives in generated buildings: they are of {Settings.hardware}, which has another base")
        checks = 0
    learner = Learner(data, policy, passes, seed, model, batch_size, place, mirror)
    options = {"passes": passes, "seed": seed, "checks": checks, "model": model, "prefix": policy.prefix}
    options |= {"batch_size": batch_size, "device": place.type, "mirror": mirror}
    asked = {"rows": len(data.pictures), **options}
    best = _resumed(learner, kept, asked) if resume else -1.0
    while learner.done < passes:
        progress(learner.learn())
        if not checks:
            learner.keep_best()
        elif learner.done > passes // 2:
            success = _closed_loop(_files_of(learner.network, policy), checks)
            progress(f"pass {learner.done} of {passes}: SR {success:.3f} in {checks} generated buildings")
            if success >= best:
                best = success
                learner.keep_best()
        _keep(learner, kept, asked, best)
    if checks:
        policy.training["closed loop"] = f"SR {best:.3f} in {checks} generated buildings, best of the later passes"
    made, graph, others = _files_of(learner.best_network(), policy)
    write_policy(made, graph, {**others, CURVES: (kept / CURVES).read_bytes()})
    shutil.rmtree(kept)


def _keep(learner: Learner, folder: Path, asked: dict[str, Any], best: float) -> None:
    """Writes what a training is at, all of it or nothing."""
    folder.mkdir(parents=True, exist_ok=True)
    tensors, numbers = learner.state()
    described = json.dumps({"asked": asked, "best": best, **numbers})
    save_file(tensors, folder / f"{STATE}.partial", {"training": described})
    (folder / f"{STATE}.partial").replace(folder / STATE)
    rows = [",".join("" if value is None else f"{value:.6g}" for value in row) for row in learner.curve]
    (folder / CURVES).write_text("\n".join(["step,train,held_out", *rows, ""]), encoding="utf-8")


def _resumed(learner: Learner, folder: Path, asked: dict[str, Any]) -> float:
    """Lets a learner go on where another one was; the success of the best so far. Raises ConfigError."""
    path = folder / STATE
    try:
        with safe_open(path, "pt") as file:
            numbers = json.loads((file.metadata() or {})["training"])
            was = numbers["asked"]
            if was == asked:
                learner.restore(load_file(path), numbers)
                return float(numbers["best"])
    except (OSError, SafetensorError, LookupError, TypeError, ValueError, RuntimeError) as error:
        raise ConfigError(f"{path}: no training that can go on: {error}") from None
    raise ConfigError(f"{path}: is of {was}, and asked for is {asked}")


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


def _policy_of(source: Dataset, output: Path, data: Demonstrations, chunk: int) -> Policy:
    names = [each.name for each in velocities_of(source)]
    learnt = data.actions[~data.held_out & data.wanted.all(1)].reshape(-1, len(names))
    _, height, width, _ = data.pictures.shape
    return Policy(
        folder=output,
        kinematics=Kinematics.holonomic if "vy" in names else Kinematics.differential,
        cameras=(CameraInput(CAMERA, height, width, "rgb"),),
        state=(),
        action=tuple(
            Quantity(name, NAMES[name], float(learnt[:, i].mean()), max(LEAST_STD, float(learnt[:, i].std())))
            for i, name in enumerate(names)
        ),
        rate=float(source.fps),
        chunk=chunk,
        latency=LATENCY,
        merge="blend",
        language=True,
        training={"robot": str(source.info.robot_type)},
    )


@dataclass(frozen=True)
class _Batch:
    """Rows of one step."""

    rows: NDArray[np.int64]
    mirrored: NDArray[np.bool_]
    """which of them are shown with left and right exchanged"""


class Learner:
    """A network that learns, pass by pass. The same seed repeats it on one machine."""

    def __init__(
        self,
        data: Demonstrations,
        policy: Policy,
        passes: int,
        seed: int,
        model: str,
        batch_size: int,
        device: torch.device,
        mirror: bool,
    ) -> None:
        torch.set_num_threads(1)  # layers this small wait for one another on more, and the order of sums would differ
        torch.manual_seed(seed)
        self._random = np.random.default_rng(seed)
        self._light = torch.Generator(device).manual_seed(seed)
        self._batch_size, self._device = batch_size, device
        self._prefix, self._mirror = policy.prefix, mirror
        self._mirror_image = torch.tensor([-1.0 if q.name in SIDES else 1.0 for q in policy.action], device=device)
        mean = np.array([q.mean for q in policy.action], np.float32)
        std = np.array([q.std for q in policy.action], np.float32)
        self._targets = torch.from_numpy((data.actions - mean) / std)
        self._wanted = torch.from_numpy(data.wanted.astype(np.float32))[:, :, None]
        self._pictures = torch.from_numpy(data.pictures).permute(0, 3, 1, 2)  # as it lies in memory: faster, too
        self._embeddings = torch.from_numpy(data.embeddings)
        usable = data.wanted.any(1)
        self._learnt, self._held_out = np.flatnonzero(usable & ~data.held_out), np.flatnonzero(usable & data.held_out)
        self._network = _network(model, policy, data).to(device, memory_format=torch.channels_last)
        self._averaged = AveragedModel(self._network, avg_fn=_averaged).eval()
        self._optimizer = torch.optim.AdamW(self._network.parameters(), lr=RATES[model], weight_decay=DECAY)
        self._steps = -(-len(self._learnt) // batch_size)  # of a pass
        self._schedule = torch.optim.lr_scheduler.OneCycleLR(
            self._optimizer, RATES[model], total_steps=passes * self._steps
        )
        self._best: dict[str, torch.Tensor] = {}
        self._passes = passes
        self.done = 0
        """passes"""
        self.curve: list[tuple[int, float, float | None]] = []
        """(step, mean loss since the row before, loss of the episodes held out at the end of a pass)"""

    @property
    def network(self) -> nn.Module:
        """A copy with the mean of the weights of the last steps, on the processor."""
        return copy.deepcopy(self._averaged.module).cpu()

    def keep_best(self) -> None:
        """Keeps the network as it is now as the best one."""
        self._best = {name: value.clone() for name, value in self._averaged.module.state_dict().items()}

    def best_network(self) -> nn.Module:
        """The one that was kept last."""
        self._averaged.module.load_state_dict(self._best)
        return self.network

    def learn(self) -> str:
        """A pass over all rows; its losses, in words."""
        steps: list[torch.Tensor] = []
        order, size = self._random.permutation(self._learnt), self._batch_size
        mirrored = self._random.random(len(order)) < 0.5 * self._mirror
        batches = [_Batch(order[i : i + size], mirrored[i : i + size]) for i in range(0, len(order), size)]
        for batch, pictures in zip(batches, _ahead_of_time(self._varied, batches), strict=True):
            rows = batch.rows
            committed = self._random.integers(self._prefix + 1, size=(len(rows), 1)) if self._prefix else None
            known = None if committed is None else np.arange(self._prefix) < committed
            loss = self._loss(self._network, pictures, batch, known)
            self._optimizer.zero_grad()
            loss.backward()
            self._optimizer.step()
            self._schedule.step()
            self._averaged.update_parameters(self._network)
            steps.append(loss.detach())
        losses = torch.stack(steps).tolist()
        held_out = self._loss_held_out()
        self._draw(losses, held_out)
        self.done += 1
        text = f"pass {self.done} of {self._passes}: loss {np.mean(losses):.4f}"
        return text if held_out is None else f"{text}, held out {held_out:.4f}"

    def _varied(self, batch: _Batch) -> torch.Tensor:
        pictures, mirrored = self._seen(batch.rows), torch.from_numpy(batch.mirrored).to(self._device)
        pictures[mirrored] = pictures[mirrored].flip(3)
        return _relit(pictures, self._light)

    def _seen(self, rows: NDArray[np.int64]) -> torch.Tensor:
        return self._pictures[rows].to(self._device).float() / 255

    def _draw(self, losses: list[float], held_out: float | None) -> None:
        """Adds a pass to the curve."""
        step = self.done * self._steps
        for part in np.array_split(losses, min(POINTS, len(losses))):
            step += len(part)
            self.curve.append((step, float(part.mean()), None))
        self.curve[-1] = (*self.curve[-1][:2], held_out)

    def _loss(
        self, model: nn.Module, light: torch.Tensor, batch: _Batch, known: NDArray[np.bool_] | None = None
    ) -> torch.Tensor:
        rows = batch.rows
        embeddings, counted, targets = (
            values[rows].to(self._device) for values in (self._embeddings, self._wanted, self._targets)
        )
        targets[torch.from_numpy(batch.mirrored)] *= self._mirror_image
        given = [light, embeddings]
        if self._prefix:
            mask = torch.zeros(len(rows), self._prefix, 1)
            if known is not None:
                mask = torch.from_numpy(known)[..., None].float()
            mask = mask.to(self._device)
            given.append(torch.cat([targets[:, : self._prefix] * mask, mask], 2))
            counted = torch.cat([counted[:, : self._prefix] * (1 - mask), counted[:, self._prefix :]], 1)
        losses = nn.functional.smooth_l1_loss(model(*given), targets, reduction="none")
        return (losses * counted).sum() / (counted.sum().clamp(min=1) * targets.shape[2])

    def _loss_held_out(self) -> float | None:
        """Of the episodes that are not learnt from; None without any."""
        if not len(self._held_out):
            return None
        with torch.no_grad():
            batches = [_Batch(rows, np.zeros(len(rows), np.bool_)) for rows in _parts(self._held_out)]
            parts = [self._loss(self._averaged, self._seen(batch.rows), batch).item() for batch in batches]
        return float(np.mean(parts))

    def state(self) -> tuple[dict[str, torch.Tensor], dict[str, Any]]:
        """All that another one needs to go on in the same way: tensors, and what JSON holds."""
        tensors = {"random": self._light.get_state()}
        optimizer, schedule = self._optimizer.state_dict(), self._schedule
        moments = {f"{i}.{name}": value for i, each in optimizer["state"].items() for name, value in each.items()}
        for kind, some in (
            ("network", self._network.state_dict()),
            ("averaged", self._averaged.state_dict()),
            ("best", self._best),
            ("optimizer", moments),
        ):
            tensors |= {f"{kind}/{name}": value.contiguous() for name, value in some.items()}
        return tensors, {
            "done": self.done,
            "curve": self.curve,
            "random": self._random.bit_generator.state,
            "groups": optimizer["param_groups"],
            "schedule": [schedule.last_epoch, schedule._step_count],
        }

    def restore(self, tensors: dict[str, torch.Tensor], numbers: dict[str, Any]) -> None:
        """Goes on where the other one was."""
        kinds: dict[str, dict[str, torch.Tensor]] = {"network": {}, "averaged": {}, "best": {}, "optimizer": {}}
        for key, value in tensors.items():
            kind, _, name = key.partition("/")
            if kind in kinds:
                kinds[kind][name] = value
        self._network.load_state_dict(kinds["network"])
        self._averaged.load_state_dict(kinds["averaged"])
        self._best = kinds["best"]
        moments: dict[int, dict[str, torch.Tensor]] = {}
        for name, value in kinds["optimizer"].items():
            number, _, what = name.partition(".")
            moments.setdefault(int(number), {})[what] = value
        self._optimizer.load_state_dict({"state": moments, "param_groups": numbers["groups"]})
        self._schedule.last_epoch, self._schedule._step_count = numbers["schedule"]
        self._random.bit_generator.state = numbers["random"]
        self._light.set_state(tensors["random"])
        self.done, self.curve = numbers["done"], [tuple(row) for row in numbers["curve"]]


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


def _relit(pictures: torch.Tensor, random: torch.Generator) -> torch.Tensor:
    """The same pictures (N, 3, H, W) 0 to 1 in other light, by another camera."""

    def drawn(*shape: int) -> torch.Tensor:
        return torch.rand(shape, generator=random, device=pictures.device)

    count = len(pictures)
    gain = 1.0 + GAIN * (2.0 * drawn(count, 1, 1, 1) - 1.0)
    tint = 1.0 + TINT * (2.0 * drawn(count, 3, 1, 1) - 1.0)
    noise = NOISE * drawn(count, 1, 1, 1) * (2.0 * drawn(*pictures.shape) - 1.0)
    return (pictures * gain * tint + noise).clamp(0.0, 1.0)


def _ahead_of_time(compute: Callable[[_Batch], torch.Tensor], batches: Sequence[_Batch]) -> Iterator[torch.Tensor]:
    """What is computed of each batch, in a thread of its own while the one before is worked on."""
    with ThreadPoolExecutor(1, initializer=torch.set_num_threads, initargs=(1,)) as pool:
        coming = pool.submit(compute, batches[0])
        for batch in batches[1:]:
            ready, coming = coming, pool.submit(compute, batch)
            yield ready.result()
        yield coming.result()


def _parts(rows: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    return np.array_split(rows, -(-len(rows) // 256))
