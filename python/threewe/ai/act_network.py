"""ACT in PyTorch, small, by the names that LeRobot has for its tensors, and the files that LeRobot loads.

Zhao et al., "Learning Fine-Grained Bimanual Manipulation with Low-Cost Hardware" (2023), without the variational
encoder, which LeRobot can do without, too (`use_vae`). The backbone is the least of LeRobot's, a ResNet of 18 layers.
"""

from __future__ import annotations

import json
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from threewe.ai.act import POSITION_EPSILON, TEMPERATURE, act_graph, read_act_config
from threewe.ai.checkpoint import CONFIG, PROCESSORS, WEIGHTS, read_checkpoint
from threewe.ai.folder import ACTION, EMBEDDED, EMBEDDING, Policy, image_input

WIDTH, HEADS, HIDDEN, LATENT = 128, 4, 256, 32
ENCODER_LAYERS, DECODER_LAYERS = 2, 1
STAGES = (64, 128, 256, 512)  # channels of the backbone's
LEAST_STD = 0.01  # of a colour, 0 to 1
EPSILON = 1e-8  # beside a standard deviation


class ActNetwork(nn.Module):
    """Pictures (N, 3, H, W) 0 to 1 and embeddings (N, 64) to normalised actions (N, chunk, numbers)."""

    def __init__(self, chunk: int, numbers: int, mean: NDArray[np.float32], std: NDArray[np.float32]) -> None:
        """Mean and standard deviation (3,) are of the pictures' colours."""
        super().__init__()
        self.mean = mean.reshape(3, 1, 1)
        self.std = np.maximum(LEAST_STD, std).reshape(3, 1, 1)
        self.backbone = _Backbone()
        self.encoder_img_feat_input_proj = nn.Conv2d(STAGES[-1], WIDTH, 1)
        self.encoder_latent_input_proj = nn.Linear(LATENT, WIDTH)
        self.encoder_env_state_input_proj = nn.Linear(EMBEDDING, WIDTH)
        self.encoder_1d_feature_pos_embed = nn.Embedding(2, WIDTH)  # latent, instruction
        self.encoder = _Stack(ENCODER_LAYERS, cross=False)
        self.decoder = _Stack(DECODER_LAYERS, cross=True)
        self.decoder_pos_embed = nn.Embedding(chunk, WIDTH)
        self.action_head = nn.Linear(WIDTH, numbers)

    def forward(self, pictures: Tensor, embeddings: Tensor) -> Tensor:
        """See the class."""
        count = len(pictures)
        normal = (pictures - torch.from_numpy(self.mean)) / (torch.from_numpy(self.std) + EPSILON)
        features = self.encoder_img_feat_input_proj(self.backbone(normal))
        latent = self.encoder_latent_input_proj(torch.zeros(count, LATENT))
        instruction = self.encoder_env_state_input_proj(embeddings)
        tokens = torch.cat([torch.stack([latent, instruction]), features.flatten(2).permute(2, 0, 1)])
        pixels = _grid_positions(features.shape[2], features.shape[3])
        positions = torch.cat([self.encoder_1d_feature_pos_embed.weight, pixels])[:, None]
        encoded = self.encoder(tokens, positions)
        queries = self.decoder_pos_embed.weight[:, None]
        decoded = self.decoder(torch.zeros(len(queries), count, WIDTH), queries, encoded, positions)
        actions: Tensor = self.action_head(decoded.transpose(0, 1))
        return actions


class _FrozenNorm(nn.Module):
    """Batch norm that learns nothing, as LeRobot's backbones have it."""

    def __init__(self, width: int) -> None:
        super().__init__()
        for name, value in (("weight", 1.0), ("bias", 0.0), ("running_mean", 0.0), ("running_var", 1.0)):
            self.register_buffer(name, torch.full((width,), value))

    def forward(self, x: Tensor) -> Tensor:
        weight, bias, mean, variance = (each[None, :, None, None] for each in self.buffers())
        normed: Tensor = (x - mean) * (weight / torch.sqrt(variance + 1e-5)) + bias
        return normed


class _Block(nn.Module):
    """Two convolutions, and what goes past them (He et al. 2016)."""

    def __init__(self, inputs: int, outputs: int) -> None:
        super().__init__()
        stride = 1 if inputs == outputs else 2
        self.conv1 = nn.Conv2d(inputs, outputs, 3, stride, 1, bias=False)
        self.bn1 = _FrozenNorm(outputs)
        self.conv2 = nn.Conv2d(outputs, outputs, 3, 1, 1, bias=False)
        self.bn2 = _FrozenNorm(outputs)
        self.downsample: nn.Module | None = None
        if stride > 1:
            self.downsample = nn.Sequential(nn.Conv2d(inputs, outputs, 1, stride, bias=False), _FrozenNorm(outputs))

    def forward(self, x: Tensor) -> Tensor:
        past = x if self.downsample is None else self.downsample(x)
        return torch.relu(self.bn2(self.conv2(torch.relu(self.bn1(self.conv1(x))))) + past)


class _Backbone(nn.Module):
    """A ResNet of 18 layers."""

    def __init__(self) -> None:
        super().__init__()
        self.conv1 = nn.Conv2d(3, STAGES[0], 7, 2, 3, bias=False)
        self.bn1 = _FrozenNorm(STAGES[0])
        for i, (inputs, outputs) in enumerate(zip((STAGES[0], *STAGES), STAGES, strict=False), 1):
            self.add_module(f"layer{i}", nn.Sequential(_Block(inputs, outputs), _Block(outputs, outputs)))
        for name, part in self.named_modules():
            if name.endswith("conv2"):
                nn.init.zeros_(part.weight)  # no norm keeps the sums of many blocks small
            elif isinstance(part, nn.Conv2d):
                nn.init.kaiming_normal_(part.weight, mode="fan_out", nonlinearity="relu")

    def forward(self, x: Tensor) -> Tensor:
        x = nn.functional.max_pool2d(torch.relu(self.bn1(self.conv1(x))), 3, 2, 1)
        for i in range(len(STAGES)):
            x = self.get_submodule(f"layer{i + 1}")(x)
        return x


class _Layer(nn.Module):
    """Of the encoder, or with `cross` of the decoder (Vaswani et al. 2017)."""

    def __init__(self, cross: bool) -> None:
        super().__init__()
        self.self_attn = nn.MultiheadAttention(WIDTH, HEADS)
        self.linear1, self.linear2 = nn.Linear(WIDTH, HIDDEN), nn.Linear(HIDDEN, WIDTH)
        self.norm1, self.norm2 = nn.LayerNorm(WIDTH), nn.LayerNorm(WIDTH)
        if cross:
            self.multihead_attn = nn.MultiheadAttention(WIDTH, HEADS)
            self.norm3 = nn.LayerNorm(WIDTH)
        self.cross = cross

    def forward(self, x: Tensor, own: Tensor, encoded: Tensor | None = None, places: Tensor | None = None) -> Tensor:
        x = self.norm1(x + self.self_attn(x + own, x + own, x, need_weights=False)[0])
        last = self.norm2
        if encoded is not None and places is not None:
            x = self.norm2(x + self.multihead_attn(x + own, encoded + places, encoded, need_weights=False)[0])
            last = self.norm3
        out: Tensor = last(x + self.linear2(torch.relu(self.linear1(x))))
        return out


class _Stack(nn.Module):
    def __init__(self, count: int, cross: bool) -> None:
        super().__init__()
        self.layers = nn.ModuleList(_Layer(cross) for _ in range(count))
        self.norm = nn.LayerNorm(WIDTH) if cross else nn.Identity()

    def forward(self, x: Tensor, *others: Tensor) -> Tensor:
        for layer in self.layers:
            x = layer(x, *others)
        normed: Tensor = self.norm(x)
        return normed


def _grid_positions(height: int, wide: int) -> Tensor:
    """(height * wide, WIDTH) sines and cosines of a pixel's row, then of its column, as fractions of 2 pi."""
    half = WIDTH // 2
    frequency = TEMPERATURE ** (2 * (torch.arange(half) // 2) / half)

    def waves(count: int) -> Tensor:
        place = torch.arange(1, count + 1) / (count + POSITION_EPSILON) * 2 * torch.pi
        angle = place[:, None] / frequency
        return torch.stack([angle[:, 0::2].sin(), angle[:, 1::2].cos()], -1).flatten(1)

    rows = waves(height)[:, None].expand(height, wide, half)
    columns = waves(wide)[None].expand(height, wide, half)
    return torch.cat([rows, columns], -1).flatten(0, 1)


def act_files(network: ActNetwork, policy: Policy) -> dict[str, bytes]:
    """The files of LeRobot's checkpoint by their names: its configuration, weights and processors."""
    from safetensors.torch import save

    camera = policy.cameras[0]
    picture = image_input(camera.name)
    inputs = {
        picture: {"type": "VISUAL", "shape": [3, camera.height, camera.width]},
        EMBEDDED: {"type": "ENV", "shape": [EMBEDDING]},
    }
    outputs = {ACTION: {"type": "ACTION", "shape": [len(policy.action)]}}
    modes = {"VISUAL": "MEAN_STD", "STATE": "MEAN_STD", "ENV": "IDENTITY", "ACTION": "MEAN_STD"}
    config = {
        "type": "act",
        "n_obs_steps": 1,
        "input_features": inputs,
        "output_features": outputs,
        "device": "cpu",
        "push_to_hub": False,
        "normalization_mapping": modes,
        "vision_backbone": "resnet18",
        "pretrained_backbone_weights": None,
        "replace_final_stride_with_dilation": False,
        "pre_norm": False,
        "feedforward_activation": "relu",
        "use_vae": False,
        "temporal_ensemble_coeff": None,
        "chunk_size": policy.chunk,
        "n_action_steps": 1,
        "dim_model": WIDTH,
        "n_heads": HEADS,
        "dim_feedforward": HIDDEN,
        "latent_dim": LATENT,
        "n_encoder_layers": ENCODER_LAYERS,
        "n_decoder_layers": DECODER_LAYERS,
        "n_vae_encoder_layers": 1,
    }
    statistics = {f"{picture}.mean": network.mean, f"{picture}.std": network.std}
    for each in ("mean", "std"):
        statistics[f"{ACTION}.{each}"] = np.array([getattr(q, each) for q in policy.action], np.float32)
    tensors = {name: torch.from_numpy(values) for name, values in statistics.items()}
    scaled = {"eps": EPSILON, "norm_map": modes}
    device = {"registry_name": "device_processor", "config": {"device": "cpu", "float_dtype": None}}
    before: list[dict[str, Any]] = [
        {"registry_name": "rename_observations_processor", "config": {"rename_map": {}}},
        {"registry_name": "to_batch_processor", "config": {}},
        device,
        {"registry_name": "normalizer_processor", "config": {**scaled, "features": {**inputs, **outputs}}},
    ]
    after = [{"registry_name": "unnormalizer_processor", "config": {**scaled, "features": outputs}}, device]
    weights = {f"model.{name}": values.contiguous() for name, values in network.state_dict().items()}
    files = {CONFIG: _json(config), WEIGHTS: save(weights)}
    for processor, steps in zip(PROCESSORS, (before, after), strict=True):
        kind = processor.removesuffix(".json")
        for i, step in enumerate(steps):
            if "normalizer" in step["registry_name"]:
                step["state_file"] = f"{kind}_step_{i}_{step['registry_name']}.safetensors"
                files[step["state_file"]] = save(tensors)
        files[processor] = _json({"name": kind, "steps": steps})
    return files


def _json(content: dict[str, Any]) -> bytes:
    return (json.dumps(content, indent=2) + "\n").encode()


def act_to_onnx(files: dict[str, bytes], policy: Policy) -> bytes:
    """The graph of such a checkpoint, for a policy whose actions it gives in their units."""
    with TemporaryDirectory() as folder:
        for name, content in files.items():
            Path(folder, name).write_bytes(content)
        checkpoint = read_checkpoint(folder)
        return act_graph(checkpoint, read_act_config(checkpoint), policy)
