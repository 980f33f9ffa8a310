"""Feed-forward policies (multilayer perceptrons) as safetensors: weights, and metadata that describes the network.

The format `threewe-mlp/1` is a safetensors file, all of it float32:

- `input.mean`, `input.standard_deviation` (inputs,): how observations are normalised, in their own units.
- `layers.I.weight` (outputs, inputs), `layers.I.bias` (outputs,): I from 0, as PyTorch's `Linear` has them.
- `action.scale` (3,): what the last layer's outputs are multiplied by.

One entry `threewe` of its metadata is a JSON object, here with what may be left out as it is then:

    {"format": "threewe-mlp/1", "observations": [["goal", 2], ["lidar", 72]], "sizes": [74, 64, 64, 3],
     "activation": "tanh", "output_activation": "none", "input_clip": null, "control_rate": null, "goal_frame": "robot"}
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from threewe._core import unknown_name
from threewe._extras import needed_for
from threewe._files import require_file
from threewe.errors import ConfigError

FORMAT = "threewe-mlp/1"
ENTRY = "threewe"  # one: safetensors writes several in any order
VECTORS = {"lidar": None, "goal": 2, "pose": 3, "velocity": 3, "object_goal": 10}  # and their lengths, lidar's own
OPTIONAL: dict[str, Any] = {
    "output_activation": "none",
    "input_clip": None,
    "control_rate": None,
    "goal_frame": "robot",
}
LARGEST = 64 << 20  # [bytes] of a file
LARGEST_HEADER = 1 << 20  # [bytes] of its description
MOST_LAYERS = 64
STOP_WITHIN = 0.3  # [m] of the goal, by the robot's own belief

Values = NDArray[np.float64]
ACTIVATIONS: dict[str, Callable[[Values], Values]] = {
    "none": lambda x: x,
    "tanh": np.tanh,
    "relu": lambda x: np.maximum(x, 0.0),
    "elu": lambda x: np.where(x > 0.0, x, np.expm1(np.minimum(x, 0.0))),
    "silu": lambda x: x * (0.5 + 0.5 * np.tanh(0.5 * x)),
}


@dataclass(frozen=True, eq=False)
class MlpPolicy:
    """A feed-forward network from named observations to an action, and an agent that acts.

    action = clip(scale * output(W h + b), -1, 1), where h are the inputs, clip((x - mean) / standard deviation), after
    the layers before. Where `goal` is among its observations, it stops within 0.3 m of it, by its own belief.
    """

    observations: Mapping[str, int]  # lengths by name, in the order of the inputs
    layers: Sequence[tuple[ArrayLike, ArrayLike]]  # weight (outputs, inputs) and bias (outputs,)
    activation: str = "tanh"  # after each layer but the last: tanh, relu, elu, silu or none
    output_activation: str = "none"  # after the last
    mean: ArrayLike | None = None  # (inputs,) in the observations' units; zeros where left out
    standard_deviation: ArrayLike | None = None  # (inputs,) likewise; ones
    input_clip: float | None = None  # normalised inputs stay within +-this
    action_scale: ArrayLike = (1.0, 1.0, 1.0)
    control_rate: float | None = None  # [Hz] that it was trained at; the run's where left out
    goal_frame: str = "robot"  # of `goal`, or "map"

    def __post_init__(self) -> None:
        """Makes arrays of what was given. Raises ConfigError naming what does not fit."""
        observations = _observations(self.observations)
        inputs = sum(observations.values())
        layers = [(_array(weight), _array(bias)) for weight, bias in self.layers]
        sizes = [inputs, *(weight.shape[0] if weight.ndim == 2 else 0 for weight, _ in layers)]
        if not 1 <= len(layers) <= MOST_LAYERS:
            raise ConfigError(f"layers: expected 1 to {MOST_LAYERS}, got {len(layers)}")
        given = {
            "mean": _array(self.mean if self.mean is not None else np.zeros(inputs)),
            "standard_deviation": _array(
                self.standard_deviation if self.standard_deviation is not None else np.ones(inputs)
            ),
            "action_scale": _array(self.action_scale),
        }
        for name, value in {"observations": observations, "layers": layers, **given}.items():
            object.__setattr__(self, name, value)
        _require_shapes(self.tensors(), [*sizes[:-1], 3])
        if not (given["standard_deviation"] > 0.0).all():
            raise ConfigError("input.standard_deviation: expected numbers above 0")
        for name in ("activation", "output_activation"):
            if getattr(self, name) not in ACTIVATIONS:
                raise ConfigError(f"{name}: {unknown_name('activation', str(getattr(self, name)), list(ACTIVATIONS))}")
        for name in ("input_clip", "control_rate"):
            if (value := getattr(self, name)) is not None and not _is_positive(value):
                raise ConfigError(f"{name}: expected a number above 0, got {value!r}")
        if self.goal_frame not in ("robot", "map"):
            raise ConfigError(f"goal_frame: expected 'robot' or 'map', got {self.goal_frame!r}")

    @classmethod
    def load(cls, path: str | Path) -> MlpPolicy:
        """Reads a file. Raises ConfigError naming file and field."""
        path = Path(path)
        try:
            described, tensors = _read(path)
            return cls(**_fields(described, tensors))
        except ConfigError as error:
            raise ConfigError(f"{path}: {error}") from None

    def save(self, path: str | Path) -> None:
        """Writes a file: the same bytes for the same policy."""
        with needed_for("policies as safetensors", "policy"):
            from safetensors.numpy import save
        described = {
            "format": FORMAT,
            "observations": [list(pair) for pair in self.observations.items()],
            "sizes": [sum(self.observations.values()), *(len(np.asarray(bias)) for _, bias in self.layers)],
            "activation": self.activation,
            **{name: getattr(self, name) for name in OPTIONAL},
        }
        tensors = {name: np.ascontiguousarray(value, np.float32) for name, value in self.tensors().items()}
        Path(path).write_bytes(save(tensors, metadata={ENTRY: json.dumps(described, allow_nan=False)}))

    def tensors(self) -> dict[str, NDArray[np.float32]]:
        """All numbers, by the names that they have in a file."""
        found = {f"layers.{i}.weight": weight for i, (weight, _) in enumerate(self.layers)}
        found |= {f"layers.{i}.bias": bias for i, (_, bias) in enumerate(self.layers)}
        given = {"input.mean": self.mean, "input.standard_deviation": self.standard_deviation}
        return {
            name: np.asarray(value) for name, value in {**given, **found, "action.scale": self.action_scale}.items()
        }

    @property
    def options(self) -> dict[str, Any]:
        """What its environment is made with."""
        chosen: dict[str, Any] = {"observations": tuple(self.observations)}
        if "lidar" in self.observations:
            chosen["lidar_beams"] = self.observations["lidar"]
        if "goal" in self.observations:
            chosen["goal_frame"] = self.goal_frame
        return chosen | ({} if self.control_rate is None else {"control_rate": self.control_rate})

    def act(self, observation: Mapping[str, NDArray[Any]]) -> NDArray[np.float32]:
        """An action (3,) in [-1, 1]."""
        if "goal" in observation and float(np.linalg.norm(observation["goal"])) < STOP_WITHIN:
            return np.zeros(3, np.float32)
        return self.forward(np.concatenate([observation[name] for name in self.observations]))

    def forward(self, values: ArrayLike) -> NDArray[np.float32]:
        """Observations one after the other, (inputs,) or (n, inputs) in their units, to actions (3,) or (n, 3)."""
        hidden = (np.asarray(values, float) - np.asarray(self.mean)) / np.asarray(self.standard_deviation)
        if self.input_clip is not None:
            hidden = np.clip(hidden, -self.input_clip, self.input_clip)
        for i, (weight, bias) in enumerate(self.layers):
            is_last = i + 1 == len(self.layers)
            hidden = hidden @ np.asarray(weight, float).T + np.asarray(bias)
            hidden = ACTIVATIONS[self.output_activation if is_last else self.activation](hidden)
        actions: NDArray[np.float32] = np.clip(hidden * np.asarray(self.action_scale), -1.0, 1.0).astype(np.float32)
        return actions


def _observations(given: Mapping[str, int]) -> dict[str, int]:
    if not given:
        raise ConfigError("observations: expected one or more")
    for name, length in given.items():
        if name not in VECTORS:
            known = unknown_name("observation", str(name), list(VECTORS))
            raise ConfigError(f"observations: {known}; images and maps need an ONNX graph")
        expected = VECTORS[name]
        if isinstance(length, bool) or not isinstance(length, int) or not 1 <= length <= 100_000:
            raise ConfigError(f"observations: {name}: expected its length, got {length!r}")
        if expected is not None and length != expected:
            raise ConfigError(f"observations: {name} has {expected} numbers, not {length}")
    return dict(given)


def _array(value: ArrayLike) -> NDArray[np.float32]:
    return np.array(value, np.float32)


def _require_shapes(tensors: Mapping[str, NDArray[Any]], sizes: Sequence[int]) -> None:
    """All tensors have the shapes that follow from these sizes, and finite numbers."""
    expected = _shapes(sizes)
    for name, value in tensors.items():
        if value.shape != expected[name]:
            raise ConfigError(f"{name}: expected shape {expected[name]}, got {value.shape}")
        if not np.isfinite(value).all():
            raise ConfigError(f"{name}: not all of its numbers are finite")


def _shapes(sizes: Sequence[int]) -> dict[str, tuple[int, ...]]:
    shapes: dict[str, tuple[int, ...]] = {"action.scale": (sizes[-1],)}
    shapes |= dict.fromkeys(("input.mean", "input.standard_deviation"), (sizes[0],))
    for i, (inputs, outputs) in enumerate(pairwise(sizes)):
        shapes |= {f"layers.{i}.weight": (outputs, inputs), f"layers.{i}.bias": (outputs,)}
    return shapes


def _read(path: Path) -> tuple[dict[str, Any], dict[str, NDArray[np.float32]]]:
    """What a file says about itself, and its tensors, which are those that it should have."""
    _require_small(path)
    with needed_for("policies as safetensors", "policy"):
        from safetensors import SafetensorError, safe_open
    try:
        with safe_open(str(path), framework="numpy") as file:
            described = _description(file.metadata() or {})
            shapes = _shapes(described["sizes"])
            for name in file.keys():  # noqa: SIM118 (no mapping)
                if name not in shapes:
                    raise ConfigError(unknown_name("tensor", name, sorted(shapes)))
            for name, shape in shapes.items():
                if name not in file.keys():  # noqa: SIM118
                    raise ConfigError(f"missing tensor {name!r}, which the sizes ask for")
                part = file.get_slice(name)
                if part.get_dtype() != "F32":
                    raise ConfigError(f"{name}: expected F32, got {part.get_dtype()}")
                if tuple(part.get_shape()) != shape:
                    raise ConfigError(f"{name}: expected shape {shape}, got {tuple(part.get_shape())}")
            return described, {name: file.get_tensor(name) for name in shapes}
    except (SafetensorError, OSError) as error:
        raise ConfigError(f"no whole safetensors file: {error}") from None


def _require_small(path: Path) -> None:
    require_file(path)
    if path.stat().st_size > LARGEST:
        raise ConfigError(f"larger than {LARGEST} bytes")
    with path.open("rb") as file:
        header = int.from_bytes(file.read(8), "little")
    if header > LARGEST_HEADER:
        raise ConfigError(f"no safetensors file: its header of {header} bytes would be larger than {LARGEST_HEADER}")


def _description(metadata: Mapping[str, str]) -> dict[str, Any]:
    """The entry `threewe` of the metadata."""
    if ENTRY not in metadata:
        raise ConfigError(
            f"its metadata has no entry {ENTRY!r}, which describes the network: `MlpPolicy.save` writes it; other "
            "networks need an ONNX graph"
        )
    try:
        described = json.loads(metadata[ENTRY])
    except (ValueError, RecursionError) as error:
        raise ConfigError(f"metadata {ENTRY!r}: {error}") from None
    if not isinstance(described, dict) or described.get("format") != FORMAT:
        raise ConfigError(f"metadata {ENTRY!r}: expected format {FORMAT!r}")
    names = ["format", "observations", "sizes", "activation", *OPTIONAL]
    for name in names:
        if name not in described and name not in OPTIONAL:
            raise ConfigError(f"metadata {ENTRY!r}: missing field {name!r}")
    for name in described:
        if name not in names:
            raise ConfigError(f"metadata {ENTRY!r}: {unknown_name('field', name, names)}")
    _require_sizes(described["sizes"])
    return {**OPTIONAL, **described}


def _require_sizes(sizes: Any) -> None:
    right = isinstance(sizes, list) and 2 <= len(sizes) <= MOST_LAYERS + 1
    if not right or not all(isinstance(n, int) and not isinstance(n, bool) and 1 <= n <= 1_000_000 for n in sizes):
        raise ConfigError(f"sizes: expected the inputs, the outputs of each of up to {MOST_LAYERS} layers, 3 at last")


def _fields(described: Mapping[str, Any], tensors: Mapping[str, NDArray[np.float32]]) -> dict[str, Any]:
    """The fields of a policy."""
    pairs = described["observations"]
    if not isinstance(pairs, list) or not all(isinstance(pair, list) and len(pair) == 2 for pair in pairs):
        raise ConfigError("observations: expected pairs of name and length")
    if not all(isinstance(name, str) for name, _ in pairs) or len({name for name, _ in pairs}) != len(pairs):
        raise ConfigError("observations: expected names, each once")
    layers = range(len(described["sizes"]) - 1)
    return {
        "observations": dict(pairs),
        "layers": [(tensors[f"layers.{i}.weight"], tensors[f"layers.{i}.bias"]) for i in layers],
        "activation": described["activation"],
        "mean": tensors["input.mean"],
        "standard_deviation": tensors["input.standard_deviation"],
        "action_scale": tensors["action.scale"],
        **{name: described[name] for name in OPTIONAL},
    }


def _is_positive(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and 0.0 < value < math.inf
