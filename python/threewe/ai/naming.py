"""Names of a foreign policy's inputs and outputs, matched with a robot's and never guessed."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeAlias

from threewe._core import Kinematics, RobotProfile
from threewe._extras import needed_for
from threewe.ai.checkpoint import Checkpoint, Feature
from threewe.ai.folder import (
    ACTION,
    CAMERA,
    EMBEDDED,
    EMBEDDING,
    IMAGES,
    MOST_CAMERAS,
    STATE,
    CameraInput,
    Policy,
    Quantity,
    is_camera,
)
from threewe.errors import ConfigError, ContractError

Rename: TypeAlias = Mapping[str, str | Sequence[str]]
"""By the policy's name: the robot's; of `observation.state` and `action`, the names of its numbers in their order."""

NUMBERS = {
    "vx": ("vx", "m/s"),
    "vy": ("vy", "m/s"),
    "omega": ("omega", "rad/s"),
    "vx.vel": ("vx", "m/s"),
    "vy.vel": ("vy", "m/s"),
    "omega.vel": ("omega", "rad/s"),
    "x.vel": ("vx", "m/s"),
    "y.vel": ("vy", "m/s"),
    "theta.vel": ("omega", "deg/s"),
}
"""Ours, ours in LeRobot's commands, and those of LeRobot's mobile robots."""
LATENCY = 0.1
"""[s] that is charged in lockstep for an inference of a policy that does not say"""
POSE = {"x", "y", "theta"}
"""Numbers of a state that our recordings have, and that no policy is given."""
OURS = "vx [m/s], vy [m/s], omega [rad/s]"


@dataclass(frozen=True)
class Naming:
    """What is known of a policy beside its files."""

    rename: Rename
    rate: float | None
    """[Hz] of its actions"""
    numbers: Mapping[str, Sequence[str]]
    """by feature, the names that its dataset has for them"""
    robot: str | None
    """that its dataset was recorded on"""


def naming_of(
    rename: Rename | None, rate: float | None, dataset: str | os.PathLike[str] | None, where: str | os.PathLike[str]
) -> Naming:
    """From what the caller passed, and from the dataset of a policy. Raises ConfigError, ContractError."""
    if rename is not None and not isinstance(rename, Mapping):
        raise ContractError(f"rename must be a mapping from the policy's names to the robot's, got {rename!r}")
    for name, new in (rename or {}).items():
        if not isinstance(name, str) or not (isinstance(new, str) or all(isinstance(each, str) for each in new)):
            raise ContractError(f"rename: {name!r}: {new!r}: names are texts, or lists of texts")
    if rate is not None and (isinstance(rate, bool) or not isinstance(rate, int | float) or not 0.5 <= rate <= 50):
        raise ContractError(f"rate must be a number in [0.5, 50] Hz, got {rate!r}")
    naming = Naming(dict(rename or {}), None if rate is None else float(rate), {}, None)
    return naming if dataset is None else _with_dataset(naming, Path(dataset), where)


def _with_dataset(naming: Naming, folder: Path, where: str | os.PathLike[str]) -> Naming:
    with needed_for("reading a dataset", "data"):
        from threewe.data.lerobot import Dataset

    source = Dataset.open(folder)
    if naming.rate is not None and naming.rate != source.fps:
        raise ConfigError(
            f"{where}: rate={naming.rate:g} Hz, and its dataset {folder} has {source.fps:g} Hz: leave rate= out"
        )
    numbers = {name: [str(each) for each in feature.names or []] for name, feature in source.features.items()}
    return replace(naming, rate=float(source.fps), numbers=numbers, robot=source.info.robot_type or None)


def policy_of(checkpoint: Checkpoint, naming: Naming, chunk: int, merge: str, language: bool) -> Policy:
    """A policy for a checkpoint of LeRobot. Raises one ConfigError with both sides, and with what would fix it."""
    match = _Match(checkpoint, naming)
    cameras = tuple(match.camera(name) for name in checkpoint.cameras())
    state = match.numbers(STATE, checkpoint.inputs.get(STATE))
    action = match.numbers(ACTION, checkpoint.outputs.get(ACTION))
    match.finish(cameras)
    velocities = [each.name for each in action]
    kinematics = kinematics_of(naming.robot, velocities)
    if kinematics is Kinematics.differential and "vy" in velocities:
        raise ConfigError(
            f"{checkpoint.config_file}: action has 'vy'; {naming.robot}, which its dataset was recorded on, has a "
            "differential base, which has none"
        )
    rate = naming.rate
    assert rate is not None
    training = {"checkpoint": checkpoint.folder.name, "kind": checkpoint.kind}
    return Policy(
        checkpoint.folder, kinematics, cameras, state, action, rate, chunk, LATENCY, merge, language, training
    )


def kinematics_of(robot: str | None, velocities: Sequence[str]) -> Kinematics:
    """How a robot drives, by its profile; by the names of its velocities where it is none of ours."""
    try:
        return RobotProfile.load(robot or "").kinematics
    except ConfigError:
        return Kinematics.holonomic if "vy" in velocities else Kinematics.differential


class _Match:
    """Collects what does not fit, so that one error says all of it."""

    def __init__(self, checkpoint: Checkpoint, naming: Naming) -> None:
        self.checkpoint, self.naming = checkpoint, naming
        self.rename = {**checkpoint.renamed(), **{self._full(name): new for name, new in naming.rename.items()}}
        self.used: set[str] = set()
        self.wrong: list[str] = []
        self.fix: dict[str, str | list[str]] = {}

    def _full(self, name: str) -> str:
        return IMAGES + name if IMAGES + name in self.checkpoint.inputs else name

    def _new(self, name: str) -> str | Sequence[str] | None:
        self.used.add(name)
        return self.rename.get(name)

    def camera(self, feature: str) -> CameraInput:
        _, height, width = self.checkpoint.inputs[feature].shape
        new = self._new(feature) or feature
        name = str(new).removeprefix(IMAGES)
        if not is_camera(name):
            self.wrong.append(f"camera {name!r}")
            self.fix[feature] = CAMERA
        return CameraInput(name, height, width, "rgb")

    def numbers(self, feature: str, found: Feature | None) -> tuple[Quantity, ...]:
        if found is None:
            if feature == ACTION:
                self.wrong.append("it gives no 'action'")
            return ()
        (length,) = found.shape
        new = self._new(feature)
        names = (
            list(self.naming.numbers.get(feature, [])) if new is None else [new] if isinstance(new, str) else list(new)
        )
        named = [str(self._new(name) or name) for name in names]
        if len(named) != length:
            has = f"{len(named)} names ({', '.join(named)})" if named else "no names"
            self.wrong.append(f"{feature} has {length} numbers and {has}")
        elif unknown := [name for name in named if name not in NUMBERS]:
            self.wrong.append(f"{feature} is ({', '.join(named)}); not known: {', '.join(unknown)}")
            if feature == STATE and set(unknown) <= POSE:
                self.wrong.append("where a robot stands is of its own map: train without (--policy.input_features)")
        elif len({NUMBERS[name][0] for name in named}) < length:
            self.wrong.append(f"{feature} is ({', '.join(named)}): one of them stands twice")
        else:
            return tuple(Quantity(*NUMBERS[name], 0.0, 1.0) for name in named)
        if length <= len(OURS.split(", ")):
            self.fix[feature] = ["vx", "vy", "omega"] if length == 3 else ["vx", "omega"][:length]
        return ()

    def finish(self, cameras: tuple[CameraInput, ...]) -> None:
        where, inputs = self.checkpoint.config_file, self.checkpoint.inputs
        if not 1 <= len(cameras) <= MOST_CAMERAS:
            raise ConfigError(
                f"{where}: input_features: {len(cameras)} cameras; a policy here acts on 1 to {MOST_CAMERAS}"
            )
        names = [camera.name for camera in cameras]
        if len(set(names)) < len(names):
            raise ConfigError(
                f"{where}: two cameras would be one: {', '.join(names)}; rename= gives each a name of its own"
            )
        if others := [n for n, f in inputs.items() if f.kind != "VISUAL" and n not in (STATE, EMBEDDED)]:
            raise ConfigError(
                f"{where}: input_features.{others[0]}: a robot of 3we gives pictures, {OURS}, and instructions"
            )
        embedding = inputs.get(EMBEDDED)
        if embedding is not None and embedding.shape != (EMBEDDING,):
            raise ConfigError(
                f"{where}: observation.environment_state has {embedding.shape[0]} numbers; "
                f"3we gives the {EMBEDDING} of an "
                f"instruction's embedding"
            )
        if unused := sorted(set(self.rename) - self.used - set(self.checkpoint.renamed())):
            has = ", ".join(sorted({*inputs, *self.checkpoint.outputs} | self.used))
            raise ConfigError(f"{where}: rename: the policy has no {unused[0]!r}; it has {has}")
        if self.wrong:
            fixed = (
                f"; if they are these in this order: rename={self.fix!r}" if self.fix else "; rename= cannot fix that"
            )
            raise ConfigError(f"{where}: {'; '.join(self.wrong)}. A robot of 3we has {OURS}{fixed}")
        if self.naming.rate is None:
            raise ConfigError(
                f"{where}: says no rate: pass rate= [Hz], that of the dataset it learnt from, or dataset=, its folder"
            )
