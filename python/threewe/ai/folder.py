"""Folder of a learned policy: `policy.json` says everything that it needs, `model.onnx` is its graph.

What another program wrote is data here: nothing in it is run before all of it has been checked, pickle never is.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from threewe._arguments import as_file
from threewe._core import Kinematics
from threewe._files import read_text, require_file
from threewe.errors import ConfigError

VERSION = 1
"""Of `policy.json`."""
DESCRIPTION, GRAPH = "policy.json", "model.onnx"
UNITS = {"vx": {"m/s": 1.0}, "vy": {"m/s": 1.0}, "omega": {"rad/s": 1.0, "deg/s": math.pi / 180}}
"""What a number of a state or an action may be called, and how much of ours one of its units is."""
LARGEST = 64 * 2**20
"""[bytes] of a graph."""
PICKLED = {".pt", ".pth", ".bin", ".ckpt", ".pkl", ".pickle", ".joblib", ".npy"}
EMBEDDING = 64
"""Numbers of an instruction."""
MOST_PIXELS = 1920


@dataclass(frozen=True)
class CameraInput:
    """A camera that a policy uses."""

    name: str
    height: int
    """[px]"""
    width: int
    """[px]"""
    color: str
    """order of the channels that its network gets: `rgb` or `bgr`"""


@dataclass(frozen=True)
class Quantity:
    """One number of a state or an action, and how it was normalised: (value - mean) / std."""

    name: str
    """`vx`, `vy` or `omega`"""
    unit: str
    """m/s, rad/s or deg/s"""
    mean: float
    """[unit]"""
    std: float
    """[unit]"""

    @property
    def scale(self) -> float:
        """How much of m/s or rad/s one unit is."""
        return UNITS[self.name][self.unit]


@dataclass(frozen=True)
class Policy:
    """What a policy needs and gives, from its `policy.json`."""

    folder: Path
    kinematics: Kinematics
    cameras: tuple[CameraInput, ...]
    state: tuple[Quantity, ...]
    action: tuple[Quantity, ...]
    rate: float
    """[Hz] of the actions of a chunk"""
    chunk: int
    """actions that it gives at once"""
    latency: float
    """[s] from a picture's inference to where its actions are applied, charged in lockstep"""
    merge: str
    """what a new chunk does to those before it: `replace`, `blend` or `ensemble`"""
    language: bool
    """it reads instructions, as their embedding"""
    training: dict[str, str]
    """where it comes from, in words"""

    def inputs(self) -> dict[str, tuple[int, ...]]:
        """The shapes of what its graph takes, by name."""
        shapes: dict[str, tuple[int, ...]] = {image_input(c.name): (1, 3, c.height, c.width) for c in self.cameras}
        if self.state:
            shapes["observation.state"] = (1, len(self.state))
        if self.language:
            shapes["observation.environment_state"] = (1, EMBEDDING)
        return shapes

    def outputs(self) -> dict[str, tuple[int, ...]]:
        """The shapes of what its graph gives, by name."""
        return {"action": (1, self.chunk, len(self.action))}


def image_input(camera: str) -> str:
    """What a camera's picture is called in datasets and graphs."""
    return f"observation.images.{camera}"


def read_policy(folder: str | os.PathLike[str]) -> Policy:
    """Reads and checks a policy's folder; runs nothing of it. Raises ConfigError with file and field."""
    root = as_file("folder", folder)
    _check_files(root)
    path = root / DESCRIPTION
    try:
        content = json.loads(read_text(path), object_pairs_hook=_without_doubles)
    except (json.JSONDecodeError, RecursionError, ValueError) as error:
        raise ConfigError(f"{path}: no JSON: {error}") from None
    policy = _parse(_Fields(path, "", content), root)

    from threewe.ai.graph import check_graph

    check_graph(root / GRAPH, policy.inputs(), policy.outputs())
    return policy


def _check_files(root: Path) -> None:
    """Refuses what is no folder of ours, by name and by its first bytes."""
    if root.suffix in PICKLED or (root.is_file() and _is_pickled(root)):
        raise ConfigError(f"{root}: pickled; loading it would run code: export the policy as ONNX")
    if not root.is_dir():
        raise ConfigError(f"{root}: {'not a folder' if root.exists() else 'no such folder'}: a policy is a folder")
    inside = root.resolve()
    for file in sorted(root.iterdir()):
        if file.is_symlink() and inside not in file.resolve().parents:
            raise ConfigError(f"{file}: a link out of the policy's folder")
        if file.suffix in PICKLED or (file.is_file() and _is_pickled(file)):
            raise ConfigError(f"{file}: pickled or TorchScript; loading it would run code: keep it elsewhere")
    for name in (DESCRIPTION, GRAPH):
        require_file(root / name)
    if (root / GRAPH).stat().st_size > LARGEST:
        raise ConfigError(f"{root / GRAPH}: larger than {LARGEST} bytes")


def _is_pickled(file: Path) -> bool:
    """Pickle of protocol 2 and later, or a zip, which is what PyTorch and TorchScript write."""
    with file.open("rb") as stream:
        first = stream.read(4)
    return first[:4] == b"PK\x03\x04" or (first[:1] == b"\x80" and first[1:2] in (b"\x02", b"\x03", b"\x04", b"\x05"))


def _without_doubles(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    names = [name for name, _ in pairs]
    if doubled := next((name for name in names if names.count(name) > 1), None):
        raise ValueError(f"field {doubled!r} stands twice")
    return dict(pairs)


class _Fields:
    """An object of the file: each field is asked for once, and none may be left."""

    def __init__(self, path: Path, place: str, content: Any) -> None:
        self.path, self.place = path, place
        if not isinstance(content, dict):
            raise ConfigError(f"{path}: {place or 'the file'} must be an object, got {type(content).__name__}")
        self.content = dict(content)

    def fail(self, field: str, what: str) -> ConfigError:
        return ConfigError(f"{self.path}: {self.place}{field}: {what}")

    def take(self, field: str, is_right: Callable[[Any], bool], what: str) -> Any:
        if field not in self.content:
            raise self.fail(field, "is missing")
        value = self.content.pop(field)
        if not is_right(value):
            raise self.fail(field, f"must be {what}, got {str(value)[:60]!r}")
        return value

    def number(self, field: str, low: float, high: float) -> float:
        def is_right(value: Any) -> bool:
            return type(value) in (int, float) and low <= value <= high

        return float(self.take(field, is_right, f"a number in [{low:g}, {high:g}]"))

    def whole(self, field: str, low: int, high: int) -> int:
        return int(
            self.take(field, lambda v: type(v) is int and low <= v <= high, f"a whole number in [{low}, {high}]")
        )

    def choice(self, field: str, choices: list[str]) -> str:
        return str(self.take(field, lambda v: v in choices, "one of " + ", ".join(choices)))

    def objects(self, field: str, least: int, most: int) -> list[_Fields]:
        what = f"a list of {least} to {most}"
        items = self.take(field, lambda v: isinstance(v, list) and least <= len(v) <= most, what)
        return [_Fields(self.path, f"{self.place}{field}[{i}].", item) for i, item in enumerate(items)]

    def finish(self) -> None:
        if self.content:
            raise self.fail(min(self.content), "is not a field that policies have")


def _parse(fields: _Fields, root: Path) -> Policy:
    fields.choice("format", ["3we-policy"])
    version = fields.whole("version", 1, 10**6)
    if version > VERSION:
        raise fields.fail("version", f"{version} is newer than {VERSION}, which this version of 3we reads: update 3we")
    kinematics = Kinematics[fields.choice("kinematics", ["holonomic", "differential"])]
    policy = Policy(
        root,
        kinematics,
        tuple(_camera(each) for each in fields.objects("cameras", 1, 1)),
        _quantities(fields, "state", 0),
        _quantities(fields, "action", 1),
        fields.number("rate", 0.5, 50.0),
        fields.whole("chunk", 2, 1000),
        fields.number("latency", 0.0, 2.0),
        fields.choice("merge", ["replace", "blend", "ensemble"]),
        bool(fields.take("language", lambda v: isinstance(v, bool), "true or false")),
        _words(_Fields(fields.path, "training.", fields.take("training", lambda v: isinstance(v, dict), "an object"))),
    )
    fields.finish()
    if kinematics is Kinematics.differential and any(each.name == "vy" for each in policy.action):
        raise fields.fail("action", "a differential base has no 'vy'")
    return policy


def _camera(fields: _Fields) -> CameraInput:
    camera = CameraInput(
        fields.choice("name", ["camera"]),
        fields.whole("height", 8, MOST_PIXELS),
        fields.whole("width", 8, MOST_PIXELS),
        fields.choice("color", ["rgb", "bgr"]),
    )
    fields.finish()
    return camera


def _quantities(fields: _Fields, field: str, least: int) -> tuple[Quantity, ...]:
    found = []
    for each in fields.objects(field, least, 3):
        name = each.choice("name", list(UNITS))
        unit = each.choice("unit", list(UNITS[name]))
        found.append(Quantity(name, unit, each.number("mean", -1e3, 1e3), each.number("std", 1e-6, 1e3)))
        each.finish()
    names = [quantity.name for quantity in found]
    if len(set(names)) < len(names):
        raise fields.fail(field, f"a name stands twice: {', '.join(names)}")
    return tuple(found)


def _words(fields: _Fields) -> dict[str, str]:
    for name, value in fields.content.items():
        if not isinstance(value, str) or len(value) > 1000:
            raise fields.fail(name, "must be a text of at most 1000 characters")
    return {str(name): str(value) for name, value in fields.content.items()}
