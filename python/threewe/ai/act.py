"""LeRobot's ACT as an ONNX graph, made of the checkpoint's own tensors: neither PyTorch nor LeRobot is needed.

Zhao et al., "Learning Fine-Grained Bimanual Manipulation with Low-Cost Hardware" (2023), as LeRobot 0.4 to 0.6 has it:
a ResNet makes tokens of pictures, a transformer encodes them with the states, another decodes a chunk of actions. The
latent of its variational encoder is zero when it acts, so that encoder is left out. Normalisation is in the graph.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from threewe.ai.checkpoint import IDENTITY, Affine, Checkpoint, Tensors
from threewe.ai.folder import ACTION, EMBEDDED, STATE, Policy, image_input

if TYPE_CHECKING:
    import onnx

BLOCKS = {"resnet18": (2, 2, 2, 2), "resnet34": (3, 4, 6, 3)}
"""Blocks of two convolutions in each stage of the backbones that are read (He et al. 2016)."""
BATCH_NORM_EPSILON = LAYER_NORM_EPSILON = 1e-5  # of torchvision's FrozenBatchNorm2d, of PyTorch's LayerNorm
TEMPERATURE = 10_000.0  # of the position embedding, in which positions are fractions of 2 pi
POSITION_EPSILON = 1e-6
VAE = "model.vae_encoder"
"""How the names of tensors begin that are for training only."""
LARGEST = {"chunk_size": 1000, "dim_model": 4096, "dim_feedforward": 16384, "n_heads": 64, "latent_dim": 4096}


@dataclass(frozen=True)
class ActConfig:
    """What `config.json` says of the network."""

    backbone: str
    width: int
    heads: int
    hidden: int
    activation: str
    encoder_layers: int
    decoder_layers: int
    latent: int
    chunk: int
    pre_norm: bool


def read_act_config(checkpoint: Checkpoint) -> ActConfig:
    """Raises ConfigError with file and field where it is no ACT that is translated here."""
    fields = checkpoint.fields()
    numbers = {name: fields.whole(name, 1, most) for name, most in LARGEST.items()}
    config = ActConfig(
        backbone=fields.choice("vision_backbone", list(BLOCKS)),
        width=numbers["dim_model"],
        heads=numbers["n_heads"],
        hidden=numbers["dim_feedforward"],
        activation=fields.choice("feedforward_activation", ["relu", "gelu", "glu"]),
        encoder_layers=fields.whole("n_encoder_layers", 1, 64),
        decoder_layers=fields.whole("n_decoder_layers", 1, 64),
        latent=numbers["latent_dim"],
        chunk=numbers["chunk_size"],
        pre_norm=fields.switch("pre_norm"),
    )
    if fields.whole("n_obs_steps", 1, 1000) != 1:
        raise fields.fail("n_obs_steps", "ACT takes one observation")
    if fields.switch("replace_final_stride_with_dilation"):
        raise fields.fail("replace_final_stride_with_dilation", "is not translated")
    if config.chunk < 2:
        raise fields.fail("chunk_size", "a chunk has two actions or more")
    if config.width % config.heads or config.width % 4:
        raise fields.fail("dim_model", f"{config.width} is no multiple of n_heads ({config.heads}) and of 4")
    if config.activation == "glu":
        raise fields.fail("feedforward_activation", "'glu' halves the width, so that LeRobot itself cannot run it")
    return config


def act_graph(checkpoint: Checkpoint, config: ActConfig, policy: Policy) -> bytes:
    """The graph for a policy whose cameras stand in the checkpoint's order. Raises ConfigError."""
    act = _Act(checkpoint.tensors(), config)
    tokens, positions = act.tokens(checkpoint, policy)
    encoded = act.encoder(tokens, positions)
    decoded = act.decoder(encoded, positions)
    flat = act.linear(decoded, "model.action_head", config.width, len(policy.action))
    scaled = act.scaled_back(flat, checkpoint.normalization(ACTION))
    act.node("Reshape", [scaled, act.constant("shape_of_actions", [1, policy.chunk, len(policy.action)])], ACTION)
    act.weights.finish(ignored=VAE)
    return bytes(act.model(policy).SerializeToString())


@dataclass
class _Act:
    """Nodes that were added so far. A sequence is (tokens, width): there is one batch."""

    weights: Tensors
    config: ActConfig
    nodes: list[Any] = field(default_factory=list)
    initializers: dict[str, Any] = field(default_factory=dict)

    def node(self, kind: str, inputs: list[str], output: str, **attributes: Any) -> str:
        from onnx import helper

        self.nodes.append(helper.make_node(kind, inputs, [output], name=output, **attributes))
        return output

    def constant(self, name: str, values: Any) -> str:
        from onnx import numpy_helper

        array = np.asarray(values)
        array = array.astype(np.float32) if array.dtype.kind == "f" else array
        self.initializers[name] = numpy_helper.from_array(np.ascontiguousarray(array), name)
        return name

    def weight(self, name: str, *shape: int) -> str:
        return self.constant(name, self.weights.take(name, shape))

    def linear(self, x: str, name: str, inputs: int, outputs: int) -> str:
        sides = [x, self.weight(f"{name}.weight", outputs, inputs), self.weight(f"{name}.bias", outputs)]
        return self.node("Gemm", sides, f"{name}.out", transB=1)

    def normed(self, x: str, name: str) -> str:
        sides = [self.weight(f"{name}.{each}", self.config.width) for each in ("weight", "bias")]
        return self.node("LayerNormalization", [x, *sides], f"{name}.out", axis=-1, epsilon=LAYER_NORM_EPSILON)

    def scaled(self, x: str, affine: Affine) -> str:
        """An input as the network takes it."""
        if affine is IDENTITY:
            return x
        moved = self.node("Sub", [x, self.constant(f"{x}.offset", affine.offset)], f"{x}.moved")
        return self.node("Div", [moved, self.constant(f"{x}.scale", affine.scale)], f"{x}.scaled")

    def scaled_back(self, x: str, affine: Affine) -> str:
        """An output in its unit."""
        if affine is IDENTITY:
            return x
        wide = self.node("Mul", [x, self.constant(f"{x}.scale", affine.scale)], f"{x}.wide")
        return self.node("Add", [wide, self.constant(f"{x}.offset", affine.offset)], f"{x}.moved")

    # tokens of the encoder: latent, state, instruction, pixels of each camera's features

    def tokens(self, checkpoint: Checkpoint, policy: Policy) -> tuple[str, str]:
        width = self.config.width
        projection = "model.encoder_latent_input_proj"
        self.weights.take(f"{projection}.weight", (width, self.config.latent))  # times a latent of zero
        tokens = [self.constant("latent", self.weights.take(f"{projection}.bias", (width,))[None])]
        for key, name in ((STATE, "robot"), (EMBEDDED, "env")):
            if key in checkpoint.inputs:
                (length,) = checkpoint.inputs[key].shape
                scaled = self.scaled(key, checkpoint.normalization(key))
                tokens.append(self.linear(scaled, f"model.encoder_{name}_state_input_proj", length, width))
        positions = [self.weights.take("model.encoder_1d_feature_pos_embed.weight", (len(tokens), width))]
        cameras = zip(checkpoint.cameras(), policy.cameras, strict=True)
        pictures = [(image_input(camera.name), checkpoint.normalization(key)) for key, camera in cameras]
        backbone = self.backbone_weights()
        for (name, affine), camera in zip(pictures, policy.cameras, strict=True):
            features = self.backbone(self.scaled(name, affine), name, backbone)
            pixels = self.node("Conv", [features, *backbone["projection"]], f"{name}.projected")
            height, wide = _reduced(camera.height), _reduced(camera.width)
            shape = self.constant(f"{name}.shape", [width, height * wide])
            flat = self.node("Reshape", [pixels, shape], f"{name}.flat")
            tokens.append(self.node("Transpose", [flat], f"{name}.tokens", perm=[1, 0]))
            positions.append(_positions(height, wide, width))
        return self.node("Concat", tokens, "tokens", axis=0), self.constant("positions", np.concatenate(positions))

    def backbone_weights(self) -> dict[str, list[str]]:
        """Weight and bias of each convolution, shared by all cameras; the frozen batch norm after it is in them."""
        found = {"conv1": self.folded("conv1", "bn1", 64, 3, 7)}
        inputs = 64
        for stage, blocks in enumerate(BLOCKS[self.config.backbone]):
            outputs = 64 * 2**stage
            for block in range(blocks):
                name = f"layer{stage + 1}.{block}"
                found[f"{name}.conv1"] = self.folded(f"{name}.conv1", f"{name}.bn1", outputs, inputs, 3)
                found[f"{name}.conv2"] = self.folded(f"{name}.conv2", f"{name}.bn2", outputs, outputs, 3)
                if block == 0 and stage > 0:
                    names = f"{name}.downsample.0", f"{name}.downsample.1"
                    found[f"{name}.downsample"] = self.folded(*names, outputs, inputs, 1)
                inputs = outputs
        name, width = "model.encoder_img_feat_input_proj", self.config.width
        found["projection"] = [self.weight(f"{name}.weight", width, inputs, 1, 1), self.weight(f"{name}.bias", width)]
        return found

    def folded(self, convolution: str, norm: str, outputs: int, inputs: int, size: int) -> list[str]:
        weight = self.weights.take(f"model.backbone.{convolution}.weight", (outputs, inputs, size, size))
        names = ("weight", "bias", "running_mean", "running_var")
        norms = [self.weights.take(f"model.backbone.{norm}.{name}", (outputs,)).astype(np.float64) for name in names]
        gain, bias, mean, variance = norms
        if (variance < 0).any():
            raise self.weights.fail(f"model.backbone.{norm}.running_var", "a variance below zero")
        gain = gain / np.sqrt(variance + BATCH_NORM_EPSILON)
        return [
            self.constant(f"{convolution}.weight", weight * gain[:, None, None, None]),
            self.constant(f"{convolution}.bias", bias - mean * gain),
        ]

    def backbone(self, x: str, camera: str, weights: dict[str, list[str]]) -> str:
        def convolution(x: str, name: str, stride: int) -> str:
            size = {"conv1": 7}.get(name, 1 if name.endswith("downsample") else 3)
            sides = {"strides": [stride] * 2, "pads": [size // 2] * 4}
            return self.node("Conv", [x, *weights[name]], f"{camera}.{name}", **sides)

        x = self.node("Relu", [convolution(x, "conv1", 2)], f"{camera}.relu")
        x = self.node("MaxPool", [x], f"{camera}.pool", kernel_shape=[3, 3], strides=[2, 2], pads=[1] * 4)
        for stage, blocks in enumerate(BLOCKS[self.config.backbone]):
            for block in range(blocks):
                name = f"layer{stage + 1}.{block}"
                stride = 2 if block == 0 and stage > 0 else 1
                inner = self.node("Relu", [convolution(x, f"{name}.conv1", stride)], f"{camera}.{name}.inner")
                residual = convolution(inner, f"{name}.conv2", 1)
                skip = convolution(x, f"{name}.downsample", 2) if stride == 2 else x
                x = self.node("Relu", [self.node("Add", [residual, skip], f"{camera}.{name}.sum")], f"{camera}.{name}")
        return x

    # transformers

    def encoder(self, x: str, positions: str) -> str:
        for i in range(self.config.encoder_layers):
            name = f"model.encoder.layers.{i}"
            x = self.residual(x, f"{name}.norm1", partial(self.self_attention, name=name, positions=positions))
            x = self.residual(x, f"{name}.norm2", partial(self.feed_forward, name=name))
        return self.normed(x, "model.encoder.norm") if self.config.pre_norm else x

    def decoder(self, encoded: str, positions: str) -> str:
        queries = self.weight("model.decoder_pos_embed.weight", self.config.chunk, self.config.width)
        keys = self.node("Add", [encoded, positions], "keys")
        x = self.constant("no_actions", np.zeros((self.config.chunk, self.config.width), np.float32))
        for i in range(self.config.decoder_layers):
            name = f"model.decoder.layers.{i}"
            attend = partial(self.cross_attention, name=name, queries=queries, keys=keys, encoded=encoded)
            x = self.residual(x, f"{name}.norm1", partial(self.self_attention, name=name, positions=queries))
            x = self.residual(x, f"{name}.norm2", attend)
            x = self.residual(x, f"{name}.norm3", partial(self.feed_forward, name=name))
        return self.normed(x, "model.decoder.norm")

    def self_attention(self, x: str, name: str, positions: str) -> str:
        query = self.node("Add", [x, positions], f"{name}.query")
        return self.attention(f"{name}.self_attn", query, query, x)

    def cross_attention(self, x: str, name: str, queries: str, keys: str, encoded: str) -> str:
        query = self.node("Add", [x, queries], f"{name}.cross_query")
        return self.attention(f"{name}.multihead_attn", query, keys, encoded)

    def residual(self, x: str, norm: str, part: Callable[[str], str]) -> str:
        """x plus a part of it, the norm before the part or after the sum."""
        if self.config.pre_norm:
            return self.node("Add", [x, part(self.normed(x, norm))], f"{norm}.sum")
        return self.normed(self.node("Add", [x, part(x)], f"{norm}.sum"), norm)

    def feed_forward(self, x: str, name: str) -> str:
        wide = self.linear(x, f"{name}.linear1", self.config.width, self.config.hidden)
        if self.config.activation == "relu":
            active = self.node("Relu", [wide], f"{name}.active")
        else:  # x (1 + erf(x / sqrt 2)) / 2
            scaled = self.node("Div", [wide, self.constant("root_of_two", np.float32(math.sqrt(2)))], f"{name}.scaled")
            error = self.node("Erf", [scaled], f"{name}.erf")
            gate = self.node("Add", [error, self.constant("one", np.float32(1))], f"{name}.gate")
            double = self.node("Mul", [wide, gate], f"{name}.double")
            active = self.node("Mul", [double, self.constant("half", np.float32(0.5))], f"{name}.active")
        return self.linear(active, f"{name}.linear2", self.config.hidden, self.config.width)

    def attention(self, name: str, query: str, key: str, value: str) -> str:
        """Softmax of query times key, times value, by heads (Vaswani et al. 2017)."""
        width, heads = self.config.width, self.config.heads
        weights = np.split(self.weights.take(f"{name}.in_proj_weight", (3 * width, width)), 3)
        biases = np.split(self.weights.take(f"{name}.in_proj_bias", (3 * width,)), 3)
        shape = self.constant("shape_of_heads", [-1, heads, width // heads])
        sides = []
        for part, x, weight, bias, order in (
            ("query", query, weights[0], biases[0], [1, 0, 2]),
            ("key", key, weights[1], biases[1], [1, 2, 0]),
            ("value", value, weights[2], biases[2], [1, 0, 2]),
        ):
            scale = 1 / math.sqrt(width // heads) if part == "query" else 1.0
            factors = [self.constant(f"{name}.{part}.weight", weight * scale)]
            factors.append(self.constant(f"{name}.{part}.bias", bias * scale))
            flat = self.node("Gemm", [x, *factors], f"{name}.{part}", transB=1)
            split = self.node("Reshape", [flat, shape], f"{name}.{part}.split")
            sides.append(self.node("Transpose", [split], f"{name}.{part}.heads", perm=order))
        products = self.node("MatMul", sides[:2], f"{name}.products")
        shares = self.node("Softmax", [products], f"{name}.shares", axis=-1)
        mixed = self.node("MatMul", [shares, sides[2]], f"{name}.mixed")
        turned = self.node("Transpose", [mixed], f"{name}.turned", perm=[1, 0, 2])
        joined = self.node("Reshape", [turned, self.constant("shape_of_tokens", [-1, width])], f"{name}.joined")
        return self.linear(joined, f"{name}.out_proj", width, width)

    def model(self, policy: Policy) -> onnx.ModelProto:
        from onnx import TensorProto, helper

        def values(shapes: dict[str, tuple[int, ...]]) -> list[Any]:
            return [helper.make_tensor_value_info(name, TensorProto.FLOAT, list(s)) for name, s in shapes.items()]

        sides = values(policy.inputs()), values(policy.outputs())
        graph = helper.make_graph(self.nodes, "act", *sides, list(self.initializers.values()))
        return helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)


def _reduced(pixels: int) -> int:
    """Height or width of the features: five times halved, rounded up."""
    for _ in range(5):
        pixels = (pixels + 1) // 2
    return pixels


def _positions(height: int, wide: int, width: int) -> NDArray[np.float32]:
    """(height * wide, width) sines and cosines of a token's place: half of them for its row, half for its column."""
    half = width // 2
    frequency = np.float32(TEMPERATURE) ** (2 * (np.arange(half, dtype=np.float32) // 2) / np.float32(half))

    def waves(count: int) -> NDArray[np.float32]:
        place = np.arange(1, count + 1, dtype=np.float32)
        place = place / (place[-1] + np.float32(POSITION_EPSILON)) * np.float32(2 * math.pi)
        angle = place[:, None] / frequency
        return np.stack([np.sin(angle[:, 0::2]), np.cos(angle[:, 1::2])], -1).reshape(count, half)

    rows = np.repeat(waves(height)[:, None], wide, 1)
    columns = np.repeat(waves(wide)[None], height, 0)
    return np.concatenate([rows, columns], -1).reshape(height * wide, width).astype(np.float32)
