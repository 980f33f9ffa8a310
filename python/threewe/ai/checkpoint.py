"""Checkpoints of LeRobot's policies: checked before anything of them is used, here or in LeRobot.

A processor file that names a class makes LeRobot import and call it, so only steps that are known here may stand in it.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from threewe._arguments import as_file
from threewe._extras import needed_for
from threewe._files import require_file
from threewe.ai.folder import Fields, read_json, refuse_code
from threewe.errors import ConfigError

CONFIG, WEIGHTS = "config.json", "model.safetensors"
PROCESSORS = "policy_preprocessor.json", "policy_postprocessor.json"
LARGEST = 2**30
"""[bytes] of weights that are translated"""
LONGEST = 10_000
"""Of one length of a feature."""
MOST_NUMBERS = 2**27
"""Of one tensor."""
STEPS = {
    *("rename_observations_processor", "to_batch_processor", "device_processor", "normalizer_processor"),
    *("unnormalizer_processor", "tokenizer_processor", "smolvla_new_line_processor", "pi0_new_line_processor"),
    *("pi05_prepare_state_tokenizer_processor_step", "relative_actions_processor", "absolute_actions_processor"),
}
"""Of processors, by the names that LeRobot has for them."""
TRANSLATED = {
    *("rename_observations_processor", "to_batch_processor", "device_processor"),
    *("normalizer_processor", "unnormalizer_processor"),
}
"""Those that a graph can do without, and those that become a part of it."""
MODES = {
    "MEAN_STD": ("mean", "std"),
    "MIN_MAX": ("min", "max"),
    "QUANTILES": ("q01", "q99"),
    "QUANTILE10": ("q10", "q90"),
}
SHAPES = {"VISUAL": 3, "STATE": 1, "ENV": 1, "ACTION": 1}
"""Dimensions of a feature."""


@dataclass(frozen=True)
class Feature:
    """An input or output."""

    kind: str
    """VISUAL, STATE, ENV or ACTION"""
    shape: tuple[int, ...]


@dataclass(frozen=True)
class Affine:
    """Normalisation: (value - offset) / scale."""

    offset: NDArray[np.float64]
    scale: NDArray[np.float64]


IDENTITY = Affine(np.zeros(1), np.ones(1))


@dataclass(frozen=True)
class Step:
    """Of a processor."""

    place: Fields
    """where it stands"""
    name: str
    config: Mapping[str, Any]
    state: Path | None
    """its tensors"""


@dataclass(frozen=True)
class Checkpoint:
    """The folder of a policy of LeRobot, vetted."""

    folder: Path
    kind: str
    """such as `act`"""
    config: Mapping[str, Any]
    inputs: Mapping[str, Feature]
    outputs: Mapping[str, Feature]
    before: tuple[Step, ...]
    """what is done with observations"""
    after: tuple[Step, ...]
    """what is done with actions"""

    @property
    def config_file(self) -> Path:
        """`config.json`"""
        return self.folder / CONFIG

    def fields(self) -> Fields:
        """Of `config.json`."""
        return Fields(self.config_file, "", self.config)

    def cameras(self) -> list[str]:
        """The names of inputs that are pictures, in the network's order."""
        return [name for name, feature in self.inputs.items() if feature.kind == "VISUAL"]

    @property
    def reads_text(self) -> bool:
        """It has a tokenizer."""
        return any("tokenizer" in step.name for step in self.before)

    @property
    def rtc(self) -> bool | None:
        """Whether real-time chunking is switched on; None for a kind of policy that has none."""
        if "rtc_config" not in self.config:
            return None
        options = self.config["rtc_config"]
        return isinstance(options, Mapping) and options.get("enabled", True) is True

    def renamed(self) -> dict[str, str]:
        """By an input's name: what datasets call it."""
        found = {}
        for step in self.before:
            if step.name == "rename_observations_processor":
                found.update({str(new): str(old) for old, new in dict(step.config.get("rename_map") or {}).items()})
        return found

    def tensors(self) -> Tensors:
        """The network's. Raises ConfigError."""
        return Tensors(self.folder / WEIGHTS)

    def normalization(self, name: str) -> Affine:
        """Of an input, or of `action`. Raises ConfigError."""
        steps, wanted = (
            (self.after, "unnormalizer_processor") if name in self.outputs else (self.before, "normalizer_processor")
        )
        feature = self.outputs[name] if name in self.outputs else self.inputs[name]
        step = next((step for step in steps if step.name == wanted), None)
        return IDENTITY if step is None else _normalization(step, name, feature, is_output=name in self.outputs)


def _normalization(step: Step, name: str, feature: Feature, is_output: bool) -> Affine:
    config = Fields(step.place.path, f"{step.place.place}config.", step.config)
    epsilon = config.number("eps", 0.0, 1.0)
    modes = config.take("norm_map", lambda v: isinstance(v, dict), "an object")
    mode = modes.get(feature.kind, "IDENTITY")
    only = config.content.get("normalize_observation_keys")
    if mode == "IDENTITY" or step.state is None or (isinstance(only, list) and name not in only and not is_output):
        return IDENTITY
    if mode not in MODES:
        raise config.fail(f"norm_map.{feature.kind}", f"must be one of IDENTITY, {', '.join(MODES)}, got {mode!r}")
    statistics = Tensors(step.state)
    first, second = (f"{name}.{each}" for each in MODES[mode])
    if not statistics.has(first) and not statistics.has(second):
        return IDENTITY  # as LeRobot does
    shape = (3, 1, 1) if feature.kind == "VISUAL" else feature.shape
    low, high = (statistics.take(each, shape, flat=True).astype(np.float64) for each in (first, second))
    if mode == "MEAN_STD":
        offset, scale = low, high + (0.0 if is_output else epsilon)
    else:  # to -1 and 1
        span = np.where(high == low, epsilon, high - low)
        offset, scale = low + span / 2, span / 2
    if not is_output and (scale == 0).any():
        raise statistics.fail(second, "nothing is divided by zero")
    return Affine(offset, scale)


class Tensors:
    """Of a safetensors file: each is asked for by name and shape. Raises ConfigError with file and tensor."""

    def __init__(self, path: Path) -> None:
        with needed_for("reading a checkpoint", "policy"):
            from safetensors import SafetensorError, safe_open
        self.path = path
        require_file(path)
        if path.stat().st_size > LARGEST:
            raise ConfigError(f"{path}: larger than {LARGEST} bytes")
        try:
            self._file: Any = safe_open(str(path), framework="numpy")
            self._names: frozenset[str] = frozenset(self._file.keys())  # type: ignore[no-untyped-call]
            self._left = set(self._names)
        except (SafetensorError, OSError) as error:
            raise ConfigError(f"{path}: no safetensors: {error}") from None

    def fail(self, name: str, what: str) -> ConfigError:
        """An error that says where."""
        return ConfigError(f"{self.path}: {name}: {what}")

    def has(self, name: str) -> bool:
        """Whether there is one of that name."""
        return name in self._names

    def take(self, name: str, shape: tuple[int, ...], flat: bool = False) -> NDArray[np.float32]:
        """float32 of that shape; with `flat`, all dimensions of length 1 may be missing."""
        if not self.has(name):
            raise self.fail(name, f"is missing; expected {_shape(shape)}")
        about = self._file.get_slice(name)
        found, kind = tuple(about.get_shape()), about.get_dtype()
        fits = [n for n in found if n != 1] == [n for n in shape if n != 1] if flat else found == shape
        if not fits or kind != "F32":
            raise self.fail(name, f"is {kind} {_shape(found)}; expected F32 {_shape(shape)}")
        if int(np.prod(shape)) > MOST_NUMBERS:
            raise self.fail(name, f"{_shape(shape)} is more than {MOST_NUMBERS} numbers")
        values = self._file.get_tensor(name).reshape(shape)
        if not np.isfinite(values).all():
            raise self.fail(name, "NaN or infinite")
        self._left.discard(name)
        return np.asarray(values, np.float32)

    def finish(self, ignored: str) -> None:
        """Raises ConfigError where there is a tensor that was not asked for, and is of no known kind."""
        if extra := sorted(name for name in self._left if not name.startswith(ignored)):
            advice = ""
            if extra[0].startswith(("normalize_", "unnormalize_")):
                advice = ": written before LeRobot 0.4; its migrate_policy_normalization.py makes processor files of it"
            raise self.fail(extra[0], f"is not a tensor of this network{advice}")


def _shape(shape: tuple[int, ...]) -> str:
    return "x".join(map(str, shape)) or "a number"


def is_checkpoint(folder: str | os.PathLike[str]) -> bool:
    """Whether a folder looks like one of LeRobot's, and not like one of ours."""
    return Path(folder, CONFIG).is_file() and not Path(folder, "policy.json").exists()


def read_checkpoint(folder: str | os.PathLike[str]) -> Checkpoint:
    """Reads and checks a checkpoint; runs nothing of it. Raises ConfigError with file and field."""
    root = as_file("folder", folder)
    refuse_code(root)
    for name in (CONFIG, WEIGHTS, *PROCESSORS):
        require_file(root / name)
    config = read_json(root / CONFIG)
    fields = Fields(root / CONFIG, "", config)
    kind = fields.take("type", lambda v: isinstance(v, str) and v.isidentifier(), "the name of a kind of policy")
    if fields.content.get("use_peft"):
        raise fields.fail("use_peft", "weights that are added to others are not read: merge them")
    before, after = (_steps(root, name) for name in PROCESSORS)
    return Checkpoint(
        root, kind, config, _features(fields, "input_features"), _features(fields, "output_features"), before, after
    )


def _features(fields: Fields, field: str) -> dict[str, Feature]:
    found = {}
    for name, content in fields.take(
        field, lambda v: isinstance(v, dict) and bool(v), "an object with features"
    ).items():
        inner = Fields(fields.path, f"{field}.{name}.", content)
        kind = inner.choice("type", list(SHAPES))
        count = SHAPES[kind]
        shape = tuple(inner.take("shape", partial(_is_shape, count), f"a list of {count} lengths"))
        if kind == "VISUAL" and shape[0] != 3:
            raise inner.fail("shape", f"a picture has 3 colours first, got {_shape(shape)}")
        found[str(name)] = Feature(kind, shape)
    return found


def _is_shape(count: int, value: Any) -> bool:
    return isinstance(value, list) and len(value) == count and all(type(n) is int and 0 < n <= LONGEST for n in value)


def _steps(root: Path, name: str) -> tuple[Step, ...]:
    """Of a processor, none of which is another class than LeRobot's own."""
    fields = Fields(root / name, "", read_json(root / name))
    steps = []
    for each in fields.objects("steps", 0, 50):
        if "class" in each.content:
            raise each.fail(
                "class", f"{str(each.content['class'])[:80]!r} would be imported and run: only steps by name are read"
            )
        kind = each.choice("registry_name", sorted(STEPS))
        config = each.take("config", lambda v: isinstance(v, dict), "an object") if "config" in each.content else {}
        state = None
        if each.content.get("state_file") is not None:
            file = each.take("state_file", _is_plain, "the name of a .safetensors file in this folder")
            require_file(state := root / file)
        if extra := sorted(set(each.content) - {"state_file"}):
            raise each.fail(extra[0], "is not a field that steps have")
        steps.append(Step(each, kind, config, state))
    return tuple(steps)


def _is_plain(name: Any) -> bool:
    return isinstance(name, str) and name.endswith(".safetensors") and Path(name).name == name
