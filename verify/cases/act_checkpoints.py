"""Checkpoints as LeRobot writes them, with drawn weights, and a slow obvious ACT in PyTorch that reads them.

Written from the papers: ACT (Zhao et al. 2023), DETR (Carion et al. 2020), ResNet (He et al. 2016). The names of its
parts are those of LeRobot's tensors.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from safetensors.numpy import load_file, save_file
from torch import Tensor, nn

Arrays = dict[str, NDArray[np.float32]]
STATE, TEXT, IMAGES = "observation.state", "observation.environment_state", "observation.images."
EXTREMES = {"MEAN_STD": ("mean", "std"), "MIN_MAX": ("min", "max"), "QUANTILES": ("q01", "q99")}


@dataclass(frozen=True)
class Shape:
    """What an ACT takes, and how it is built."""

    height: int
    width: int
    cameras: tuple[str, ...] = ("camera",)
    state: int = 3
    text: bool = True
    actions: int = 3
    modes: dict[str, str] = field(default_factory=lambda: dict.fromkeys(("VISUAL", "STATE", "ACTION"), "MEAN_STD"))
    options: dict[str, Any] = field(default_factory=dict)

    def config(self) -> dict[str, Any]:
        """As in `config.json`."""
        inputs: dict[str, Any] = {
            IMAGES + name: {"type": "VISUAL", "shape": [3, self.height, self.width]} for name in self.cameras
        }
        if self.state:
            inputs[STATE] = {"type": "STATE", "shape": [self.state]}
        if self.text:
            inputs[TEXT] = {"type": "ENV", "shape": [64]}
        sizes = {"chunk_size": 8, "dim_model": 32, "n_heads": 4, "dim_feedforward": 48, "latent_dim": 8}
        layers = {"n_encoder_layers": 2, "n_decoder_layers": 1, "n_vae_encoder_layers": 1}
        return {
            "type": "act",
            "n_obs_steps": 1,
            "input_features": inputs,
            "output_features": {"action": {"type": "ACTION", "shape": [self.actions]}},
            "device": "cpu",
            "push_to_hub": False,
            "normalization_mapping": self.modes,
            "vision_backbone": "resnet18",
            "pretrained_backbone_weights": None,
            "replace_final_stride_with_dilation": False,
            "pre_norm": False,
            "feedforward_activation": "relu",
            "use_vae": False,
            "temporal_ensemble_coeff": None,
            "n_action_steps": 8,
            **sizes,
            **layers,
            **self.options,
        }


SHAPES = {
    "64": Shape(64, 64),
    "120": Shape(120, 160, state=0, options={"pre_norm": True, "feedforward_activation": "gelu"}),
    "240": Shape(
        240,
        320,
        cameras=("front", "side"),
        text=False,
        modes={"VISUAL": "MEAN_STD", "STATE": "MIN_MAX", "ACTION": "MIN_MAX"},
    ),
    "480": Shape(
        480,
        640,
        state=0,
        text=False,
        options={"n_decoder_layers": 2, "temporal_ensemble_coeff": 0.01, "n_action_steps": 1},
    ),
}
"""64 to 480 px, one and two cameras, with and without state and instruction."""


def write(folder: Path, shape: Shape, seed: int = 1) -> Path:
    """A checkpoint with drawn weights and statistics."""
    random = np.random.default_rng(seed)
    config = shape.config()
    folder.mkdir(parents=True)
    (folder / "config.json").write_text(json.dumps(config))
    tensors = {
        f"model.{name}": drawn(random, name, tuple(each.shape)) for name, each in Twin(config).state_dict().items()
    }
    save_file(tensors, str(folder / "model.safetensors"))
    features = {**config["input_features"], **config["output_features"]}
    statistics: Arrays = {}
    for name, feature in features.items():
        size = (3, 1, 1) if feature["type"] == "VISUAL" else tuple(feature["shape"])
        middle, spread = random.normal(0.3, 0.2, size), random.uniform(0.2, 0.6, size)
        for key, values in (("mean", middle), ("std", spread), ("min", middle - spread), ("max", middle + spread)):
            statistics[f"{name}.{key}"] = np.asarray(values, np.float32)
    scaled = {"eps": 1e-8, "norm_map": shape.modes}
    device = {"registry_name": "device_processor", "config": {"device": "cpu", "float_dtype": None}}
    for processor, steps in (
        (
            "policy_preprocessor",
            [
                {"registry_name": "rename_observations_processor", "config": {"rename_map": {}}},
                {"registry_name": "to_batch_processor", "config": {}},
                device,
                {"registry_name": "normalizer_processor", "config": {**scaled, "features": features}},
            ],
        ),
        (
            "policy_postprocessor",
            [
                {
                    "registry_name": "unnormalizer_processor",
                    "config": {**scaled, "features": config["output_features"]},
                },
                device,
            ],
        ),
    ):
        for i, step in enumerate(steps):
            if "normalizer" in str(step["registry_name"]):
                step["state_file"] = f"{processor}_step_{i}_{step['registry_name']}.safetensors"
                save_file(statistics, str(folder / str(step["state_file"])))
        (folder / f"{processor}.json").write_text(json.dumps({"name": processor, "steps": steps}))
    return folder


def drawn(random: np.random.Generator, name: str, shape: tuple[int, ...]) -> NDArray[np.float32]:
    """Weights of a size that keeps signals large."""
    if name.endswith(("running_var", "norm1.weight", "norm2.weight", "norm3.weight", "bn1.weight", "bn2.weight")):
        return random.uniform(0.5, 1.5, shape).astype(np.float32)
    fan = math.prod(shape[1:]) if len(shape) > 1 else 25
    gain = math.sqrt(2) if "backbone" in name else 1.0
    if "pos_embed" in name or "action_head.weight" in name:
        gain = math.sqrt(fan)
    return random.normal(0, gain / math.sqrt(fan), shape).astype(np.float32)


def observations(shape: Shape, count: int, seed: int) -> list[Arrays]:
    """Of a batch of one each: pictures (1, 3, H, W) 0 to 1 in steps of 1 / 255."""
    random = np.random.default_rng(seed)
    found = []
    for _ in range(count):
        each: Arrays = {}
        for name in shape.cameras:
            coarse = random.integers(0, 256, (1, 3, 8, 8))
            rows, columns = np.arange(shape.height) * 8 // shape.height, np.arange(shape.width) * 8 // shape.width
            noise = random.integers(-20, 21, (1, 3, shape.height, shape.width))
            pixels = np.clip(coarse[:, :, rows][..., columns] + noise, 0, 255)
            each[IMAGES + name] = (pixels / 255).astype(np.float32)
        if shape.state:
            each[STATE] = random.normal(0, 0.5, (1, shape.state)).astype(np.float32)
        if shape.text:
            text = random.normal(size=(1, 64))
            each[TEXT] = (text / np.linalg.norm(text)).astype(np.float32)
        found.append(each)
    return found


class FrozenNorm(nn.Module):
    """Batch norm that learns nothing."""

    def __init__(self, width: int) -> None:
        super().__init__()
        for name in ("weight", "bias", "running_mean", "running_var"):
            self.register_buffer(name, torch.ones(width))

    def forward(self, x: Tensor) -> Tensor:
        w, b, m, v = (getattr(self, n)[None, :, None, None] for n in ("weight", "bias", "running_mean", "running_var"))
        return (x - m) / torch.sqrt(v + 1e-5) * w + b


class Block(nn.Module):
    def __init__(self, inputs: int, outputs: int, stride: int) -> None:
        super().__init__()
        self.conv1 = nn.Conv2d(inputs, outputs, 3, stride, 1, bias=False)
        self.bn1 = FrozenNorm(outputs)
        self.conv2 = nn.Conv2d(outputs, outputs, 3, 1, 1, bias=False)
        self.bn2 = FrozenNorm(outputs)
        self.downsample: nn.Module | None = None
        if stride > 1:
            self.downsample = nn.Sequential(nn.Conv2d(inputs, outputs, 1, stride, bias=False), FrozenNorm(outputs))

    def forward(self, x: Tensor) -> Tensor:
        skip = x if self.downsample is None else self.downsample(x)
        return torch.relu(self.bn2(self.conv2(torch.relu(self.bn1(self.conv1(x))))) + skip)


class Backbone(nn.Module):
    def __init__(self) -> None:
        super().__init__()
        self.conv1 = nn.Conv2d(3, 64, 7, 2, 3, bias=False)
        self.bn1 = FrozenNorm(64)
        self.layer1 = nn.Sequential(Block(64, 64, 1), Block(64, 64, 1))
        self.layer2 = nn.Sequential(Block(64, 128, 2), Block(128, 128, 1))
        self.layer3 = nn.Sequential(Block(128, 256, 2), Block(256, 256, 1))
        self.layer4 = nn.Sequential(Block(256, 512, 2), Block(512, 512, 1))

    def forward(self, x: Tensor) -> Tensor:
        x = nn.functional.max_pool2d(torch.relu(self.bn1(self.conv1(x))), 3, 2, 1)
        return self.layer4(self.layer3(self.layer2(self.layer1(x))))  # type: ignore[no-any-return]


class Layer(nn.Module):
    """Of the encoder, or with `cross` of the decoder."""

    def __init__(self, config: dict[str, Any], cross: bool) -> None:
        super().__init__()
        width = config["dim_model"]
        self.self_attn = nn.MultiheadAttention(width, config["n_heads"])
        if cross:
            self.multihead_attn = nn.MultiheadAttention(width, config["n_heads"])
        self.linear1, self.linear2 = (
            nn.Linear(width, config["dim_feedforward"]),
            nn.Linear(config["dim_feedforward"], width),
        )
        self.norm1, self.norm2 = nn.LayerNorm(width), nn.LayerNorm(width)
        if cross:
            self.norm3 = nn.LayerNorm(width)
        self.cross, self.first = cross, config["pre_norm"]
        self.active = getattr(torch.nn.functional, config["feedforward_activation"])

    def forward(
        self, x: Tensor, place: Tensor, memory: Tensor | None = None, memory_place: Tensor | None = None
    ) -> Tensor:
        def add(x: Tensor, norm: nn.Module, part: Any) -> Tensor:
            return x + part(norm(x)) if self.first else norm(x + part(x))  # type: ignore[no-any-return]

        x = add(x, self.norm1, lambda y: self.self_attn(y + place, y + place, y)[0])
        if memory is not None and memory_place is not None:
            x = add(x, self.norm2, lambda y: self.multihead_attn(y + place, memory + memory_place, memory)[0])
        return add(x, self.norm3 if self.cross else self.norm2, lambda y: self.linear2(self.active(self.linear1(y))))


class Stack(nn.Module):
    def __init__(self, config: dict[str, Any], cross: bool) -> None:
        super().__init__()
        count = config["n_decoder_layers" if cross else "n_encoder_layers"]
        self.layers = nn.ModuleList(Layer(config, cross) for _ in range(count))
        if cross or config["pre_norm"]:
            self.norm = nn.LayerNorm(config["dim_model"])

    def forward(self, x: Tensor, *others: Tensor) -> Tensor:
        for layer in self.layers:
            x = layer(x, *others)
        return self.norm(x) if hasattr(self, "norm") else x


class Twin(nn.Module):
    """Normalised inputs of one observation to normalised actions (chunk, numbers)."""

    def __init__(self, config: dict[str, Any]) -> None:
        super().__init__()
        self.config, width = config, config["dim_model"]
        inputs = config["input_features"]
        self.cameras = [name for name in inputs if name.startswith(IMAGES)]
        if self.cameras:
            self.backbone = Backbone()
            self.encoder_img_feat_input_proj = nn.Conv2d(512, width, 1)
        self.encoder, self.decoder = Stack(config, cross=False), Stack(config, cross=True)
        self.encoder_latent_input_proj = nn.Linear(config["latent_dim"], width)
        if STATE in inputs:
            self.encoder_robot_state_input_proj = nn.Linear(inputs[STATE]["shape"][0], width)
        if TEXT in inputs:
            self.encoder_env_state_input_proj = nn.Linear(inputs[TEXT]["shape"][0], width)
        self.encoder_1d_feature_pos_embed = nn.Embedding(1 + (STATE in inputs) + (TEXT in inputs), width)
        self.decoder_pos_embed = nn.Embedding(config["chunk_size"], width)
        self.action_head = nn.Linear(width, config["output_features"]["action"]["shape"][0])

    def forward(self, observation: dict[str, Tensor]) -> Tensor:
        kind = self.action_head.weight.dtype
        tokens = [self.encoder_latent_input_proj(torch.zeros(1, self.config["latent_dim"], dtype=kind))]
        if STATE in observation:
            tokens.append(self.encoder_robot_state_input_proj(observation[STATE]))
        if TEXT in observation:
            tokens.append(self.encoder_env_state_input_proj(observation[TEXT]))
        places = [self.encoder_1d_feature_pos_embed.weight]
        for name in self.cameras:
            features = self.encoder_img_feat_input_proj(self.backbone(observation[name]))[0]
            tokens.append(features.flatten(1).T)
            places.append(grid_places(features.shape[1], features.shape[2], self.config["dim_model"]))
        place = torch.cat(places).to(kind)
        memory = self.encoder(torch.cat(tokens), place)
        start = torch.zeros(self.config["chunk_size"], self.config["dim_model"], dtype=kind)
        return self.action_head(self.decoder(start, self.decoder_pos_embed.weight, memory, place))  # type: ignore[no-any-return]


def grid_places(rows: int, columns: int, width: int) -> Tensor:
    """Number by number: sines and cosines of a row's and a column's share of a full turn."""
    half = width // 2
    table = np.zeros((rows, columns, width))
    for k in range(half):
        frequency = 10_000 ** (2 * (k // 2) / half)
        wave = math.sin if k % 2 == 0 else math.cos
        for row in range(rows):
            table[row, :, k] = wave((row + 1) / (rows + 1e-6) * 2 * math.pi / frequency)
        for column in range(columns):
            table[:, column, half + k] = wave((column + 1) / (columns + 1e-6) * 2 * math.pi / frequency)
    return torch.from_numpy(table.reshape(rows * columns, width))


class TwinPolicy:
    """A checkpoint as LeRobot runs it: normalises, computes, and turns actions into their units."""

    def __init__(self, folder: Path) -> None:
        self.config = json.loads((folder / "config.json").read_text())
        self.network = Twin(self.config).eval()
        weights = load_file(str(folder / "model.safetensors"))
        self.network.load_state_dict({name.removeprefix("model."): torch.from_numpy(w) for name, w in weights.items()})
        (statistics,) = folder.glob("policy_preprocessor_*.safetensors")
        self.statistics = {name: torch.from_numpy(values) for name, values in load_file(str(statistics)).items()}

    def exact(self) -> TwinPolicy:
        """The same in double precision."""
        self.network.double()
        self.statistics = {name: values.double() for name, values in self.statistics.items()}
        return self

    def predict(self, observation: Arrays) -> NDArray[np.float32]:
        features = self.config["input_features"]
        kind = self.network.action_head.weight.dtype
        with torch.no_grad():
            scaled = {
                n: self.scaled(torch.from_numpy(v).to(kind), n, features[n]["type"]) for n, v in observation.items()
            }
            actions = self.network(scaled)
            mode = self.config["normalization_mapping"]["ACTION"]
            first, second = (self.statistics[f"action.{each}"] for each in EXTREMES[mode])
            given = actions * second + first if mode == "MEAN_STD" else (actions + 1) / 2 * (second - first) + first
        return given.numpy()  # type: ignore[no-any-return]

    def scaled(self, values: Tensor, name: str, kind: str) -> Tensor:
        mode = self.config["normalization_mapping"].get(kind)
        if mode is None:
            return values
        first, second = (self.statistics[f"{name}.{each}"] for each in EXTREMES[mode])
        return (values - first) / (second + 1e-8) if mode == "MEAN_STD" else 2 * (values - first) / (second - first) - 1
