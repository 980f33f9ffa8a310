"""Folder of a learned policy: `policy.json` says everything that it needs, `model.onnx` is its graph.

What another program wrote is data here: nothing in it is run before all of it has been checked, pickle never is.
"""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from itertools import islice
from pathlib import Path
from typing import Any

from threewe._arguments import as_file
from threewe._core import Kinematics, asset_directories
from threewe._files import read_text, require_file
from threewe.errors import ConfigError

VERSION = 1
"""Of `policy.json`."""
DESCRIPTION, GRAPH = "policy.json", "model.onnx"
ENCODER, HEAD = "encoder.hef", "head.onnx"
"""In place of the one graph, where convolutions run on a Hailo."""
HEF = b"\x01HEF"
"""First bytes of what Hailo's compiler writes."""
FEATURES = "features"
"""What is passed from the encoder to the head."""
UNITS = {"vx": {"m/s": 1.0}, "vy": {"m/s": 1.0}, "omega": {"rad/s": 1.0, "deg/s": math.pi / 180}}
"""What a number of a state or an action may be called, and how much of ours one of its units is."""
LARGEST = 512 * 2**20
"""[bytes] of a graph."""
MOST_FILES = 1000
"""Of a policy's folder."""
PICKLED = {".pt", ".pth", ".bin", ".ckpt", ".pkl", ".pickle", ".joblib", ".npy"}
ARCHIVES = b"PK\x03\x04", b"\x1f\x8b", b"BZh", b"\xfd7zXZ", b"\x28\xb5\x2f\xfd"
"""First bytes of zip, gzip, bzip2, xz and zstd."""
LONGEST_LATENCY = 2.0
"""[s]"""
EMBEDDING = 64
"""Numbers of an instruction."""
MOST_PIXELS = 1920
MOST_CAMERAS = 4
CAMERA = "camera"
"""What a robot's camera is called."""
STATE, EMBEDDED, ACTION, IMAGES = "observation.state", "observation.environment_state", "action", "observation.images."
"""What inputs and outputs are called in datasets and graphs; IMAGES stands before a camera's name."""
PREFIX = "action.prefix"
"""What a graph's input is called that takes the first actions of its chunk where they are committed already."""


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
    features: tuple[int, int, int] | None = None
    """(channels, height, width) of what an encoder on a Hailo gives its head; None for a policy of one graph"""
    prefix: int = 0
    """how many of a chunk's first actions it takes, as far as they are committed; 0 where it takes none"""

    def inputs(self) -> dict[str, tuple[int, ...]]:
        """The shapes of what its graph takes, by name."""
        shapes: dict[str, tuple[int, ...]] = {image_input(c.name): (1, 3, c.height, c.width) for c in self.cameras}
        if self.state:
            shapes[STATE] = (1, len(self.state))
        if self.language:
            shapes[EMBEDDED] = (1, EMBEDDING)
        if self.prefix:
            shapes[PREFIX] = (1, self.prefix, len(self.action) + 1)  # normalised, and 1 where there is one
        return shapes

    def graph_inputs(self) -> dict[str, tuple[int, ...]]:
        """The same of the graph that runs here: its head's, where an encoder takes the picture."""
        if self.features is None:
            return self.inputs()
        left = {name: shape for name, shape in self.inputs().items() if not name.startswith(IMAGES)}
        return {FEATURES: (1, *self.features), **left}

    @property
    def graph(self) -> Path:
        """The file of the graph that runs here."""
        return self.folder / (GRAPH if self.features is None else HEAD)

    def files(self) -> list[Path]:
        """All that it consists of."""
        return [self.folder / DESCRIPTION, self.graph, *([self.folder / ENCODER] if self.features else [])]

    def outputs(self) -> dict[str, tuple[int, ...]]:
        """The shapes of what its graph gives, by name."""
        return {ACTION: (1, self.chunk, len(self.action))}


def is_camera(name: Any) -> bool:
    """Whether a camera may be called so."""
    return isinstance(name, str) and re.fullmatch(r"\w{1,64}", name, re.ASCII) is not None


def image_input(camera: str) -> str:
    """What a camera's picture is called in datasets and graphs."""
    return IMAGES + camera


def read_policy(folder: str | os.PathLike[str]) -> Policy:
    """Reads and checks a policy's folder; runs nothing of it. Raises ConfigError with file and field."""
    root = find_policy(folder)
    refuse_code(root)
    path = root / DESCRIPTION
    require_file(path)
    policy = parse_policy(Fields(path, "", read_json(path)), root)
    for file in policy.files():
        require_file(file)
        if file.stat().st_size > LARGEST:
            raise ConfigError(f"{file}: larger than {LARGEST} bytes")

    from threewe.ai.graph import check_graph

    check_graph(policy.graph, policy.graph_inputs(), policy.outputs())
    if policy.features is not None:
        with (root / ENCODER).open("rb") as stream:
            if stream.read(len(HEF)) != HEF:
                raise ConfigError(f"{root / ENCODER}: not what Hailo's compiler writes")
    return policy


def find_policy(name: str | os.PathLike[str]) -> Path:
    """The folder of a policy that is shipped, by its name; else the folder itself, which need not be there."""
    path = as_file("folder", name)
    if path.exists() or len(path.parts) != 1:
        return path
    shipped = [place for folder in asset_directories() if (place := Path(folder, "policies", path)).is_dir()]
    return shipped[0] if shipped else path


def read_json(path: Path) -> Any:
    """The content of a JSON file, in which no field stands twice. Raises ConfigError."""
    try:
        return json.loads(read_text(path), object_pairs_hook=_without_doubles)
    except (json.JSONDecodeError, RecursionError, ValueError) as error:
        raise ConfigError(f"{path}: no JSON: {error}") from None


def refuse_code(root: Path) -> None:
    """Raises ConfigError where a folder is none, or holds what runs code when it is loaded: by name or first bytes."""
    if root.suffix in PICKLED or (root.is_file() and _is_pickled(root)):
        raise ConfigError(f"{root}: pickled; loading it would run code: export the policy as ONNX")
    if not root.is_dir():
        if not root.exists():
            names = sorted(path.name for folder in asset_directories() for path in Path(folder, "policies").glob("*"))
            raise ConfigError(f"{root}: no such folder; a policy is a folder, or one of {', '.join(names)}")
        raise ConfigError(f"{root}: not a folder: a policy is a folder")
    inside = root.resolve()
    files = sorted(islice(root.rglob("*"), MOST_FILES + 1))
    if len(files) > MOST_FILES:
        raise ConfigError(f"{root}: more than {MOST_FILES} files: a policy is a folder of its own")
    for file in files:
        if file.is_symlink() and inside not in file.resolve().parents:
            raise ConfigError(f"{file}: a link out of the policy's folder")
        if file.suffix in PICKLED or (file.is_file() and _is_pickled(file)):
            raise ConfigError(f"{file}: pickled or TorchScript; loading it would run code: keep it elsewhere")


def _is_pickled(file: Path) -> bool:
    """Pickle of protocol 2 and later, a zip, which is what PyTorch and TorchScript write, or what wraps either."""
    with file.open("rb") as stream:
        first = stream.read(263)
    if file.suffix == ".safetensors" and first[8:9] == b"{":  # after the length, which may be any bytes
        return False
    is_pickle = first[:1] == b"\x80" and first[1:2] in (b"\x02", b"\x03", b"\x04", b"\x05")
    return is_pickle or first.startswith(ARCHIVES) or first[257:262] == b"ustar"


def _without_doubles(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    names = [name for name, _ in pairs]
    if doubled := next((name for name in names if names.count(name) > 1), None):
        raise ValueError(f"field {doubled!r} stands twice")
    return dict(pairs)


class Fields:
    """An object of a JSON file: each field is asked for once, and none may be left."""

    def __init__(self, path: Path | str, place: str, content: Any) -> None:
        self.path, self.place = path, place
        if not isinstance(content, dict):
            raise ConfigError(f"{path}: {place or 'the file'} must be an object, got {type(content).__name__}")
        self.content = dict(content)

    # each raises ConfigError with file and field

    def fail(self, field: str, what: str) -> ConfigError:
        """An error that says where."""
        return ConfigError(f"{self.path}: {self.place}{field}: {what}")

    def take(self, field: str, is_right: Callable[[Any], bool], what: str) -> Any:
        """The value of a field."""
        if field not in self.content:
            raise self.fail(field, "is missing")
        value = self.content.pop(field)
        if not is_right(value):
            raise self.fail(field, f"must be {what}, got {str(value)[:60]!r}")
        return value

    def number(self, field: str, low: float, high: float) -> float:
        """A number, and not infinite."""

        def is_right(value: Any) -> bool:
            return type(value) in (int, float) and low <= value <= high

        return float(self.take(field, is_right, f"a number in [{low:g}, {high:g}]"))

    def whole(self, field: str, low: int, high: int) -> int:
        """A whole number."""
        return int(
            self.take(field, lambda v: type(v) is int and low <= v <= high, f"a whole number in [{low}, {high}]")
        )

    def switch(self, field: str) -> bool:
        """True or false; LeRobot writes 0 and 1, too."""
        return bool(self.take(field, lambda v: v in (True, False), "true or false"))

    def choice(self, field: str, choices: list[str]) -> str:
        """One of some words."""
        return str(self.take(field, lambda v: v in choices, "one of " + ", ".join(choices)))

    def objects(self, field: str, least: int, most: int) -> list[Fields]:
        """A list of objects."""
        what = f"a list of {least} to {most}"
        items = self.take(field, lambda v: isinstance(v, list) and least <= len(v) <= most, what)
        return [Fields(self.path, f"{self.place}{field}[{i}].", item) for i, item in enumerate(items)]

    def finish(self) -> None:
        """Nothing is left."""
        if self.content:
            raise self.fail(min(self.content), "is not a field that policies have")


def parse_policy(fields: Fields, root: Path) -> Policy:
    """A policy from the content of a `policy.json`. Raises ConfigError."""
    fields.choice("format", ["3we-policy"])
    version = fields.whole("version", 1, 10**6)
    if version > VERSION:
        raise fields.fail("version", f"{version} is newer than {VERSION}, which this version of 3we reads: update 3we")
    kinematics = Kinematics[fields.choice("kinematics", ["holonomic", "differential"])]
    policy = Policy(
        root,
        kinematics,
        _cameras(fields),
        _quantities(fields, "state", 0),
        _quantities(fields, "action", 1),
        fields.number("rate", 0.5, 50.0),
        fields.whole("chunk", 2, 1000),
        fields.number("latency", 0.0, LONGEST_LATENCY),
        fields.choice("merge", ["replace", "blend", "ensemble"]),
        bool(fields.take("language", lambda v: isinstance(v, bool), "true or false")),
        _words(Fields(fields.path, "training.", fields.take("training", lambda v: isinstance(v, dict), "an object"))),
        _features(fields),
        fields.whole("prefix", 1, 999) if "prefix" in fields.content else 0,
    )
    fields.finish()
    if policy.prefix >= policy.chunk:
        raise fields.fail("prefix", f"{policy.prefix} actions leave none of a chunk of {policy.chunk}")
    if kinematics is Kinematics.differential and any(each.name == "vy" for each in policy.action):
        raise fields.fail("action", "a differential base has no 'vy'")
    return policy


def _cameras(fields: Fields) -> tuple[CameraInput, ...]:
    cameras = tuple(_camera(each) for each in fields.objects("cameras", 1, MOST_CAMERAS))
    names = [camera.name for camera in cameras]
    if len(set(names)) < len(names):
        raise fields.fail("cameras", f"a name stands twice: {', '.join(names)}")
    return cameras


def _camera(fields: Fields) -> CameraInput:
    camera = CameraInput(
        str(fields.take("name", is_camera, "letters, digits and '_'")),
        fields.whole("height", 8, MOST_PIXELS),
        fields.whole("width", 8, MOST_PIXELS),
        fields.choice("color", ["rgb", "bgr"]),
    )
    fields.finish()
    return camera


def _quantities(fields: Fields, field: str, least: int) -> tuple[Quantity, ...]:
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


def _features(fields: Fields) -> tuple[int, int, int] | None:
    """Of an encoder, if there is one."""
    if "features" not in fields.content:
        return None

    def is_right(value: Any) -> bool:
        return isinstance(value, list) and len(value) == 3 and all(type(n) is int and 0 < n <= 4096 for n in value)

    channels, height, width = fields.take("features", is_right, "[channels, height, width] of an encoder's features")
    return channels, height, width


def _words(fields: Fields) -> dict[str, str]:
    for name, value in fields.content.items():
        if not isinstance(value, str) or len(value) > 1000:
            raise fields.fail(name, "must be a text of at most 1000 characters")
    return {str(name): str(value) for name, value in fields.content.items()}


def policy_fields(policy: Policy) -> dict[str, Any]:
    """What `policy.json` says of a policy; `parse_policy` reads it."""
    content = {"format": "3we-policy", "version": VERSION, **asdict(policy), "kinematics": policy.kinematics.name}
    del content["folder"]
    if policy.features is None:
        del content["features"]
    if not policy.prefix:
        del content["prefix"]
    return content


def write_description(policy: Policy) -> None:
    """Writes `policy.json` into a policy's folder."""
    text = json.dumps(policy_fields(policy), indent=2) + "\n"
    (policy.folder / DESCRIPTION).write_text(text, encoding="utf-8")


def write_policy(policy: Policy, graph: bytes, others: Mapping[str, bytes] | None = None) -> None:
    """Writes a policy's folder, with other files by their names; it has its name when all of it is there."""
    partial = policy.folder.with_name(f".{policy.folder.name}.{os.getpid()}.partial")
    partial.mkdir(parents=True, exist_ok=True)
    write_description(replace(policy, folder=partial))
    for name, content in {GRAPH: graph, **(others or {})}.items():
        (partial / name).write_bytes(content)
    partial.rename(policy.folder)
