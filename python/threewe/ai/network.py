"""Convolutional network of a policy, in PyTorch, and the ONNX graph that it becomes.

The instruction's embedding scales and shifts the features of every layer but the first (FiLM, Perez et al. 2018), which
has half of all features: edges and colors, that no instruction changes.
"""

from __future__ import annotations

from typing import Any

import torch
from torch import Tensor, nn

from threewe.ai.folder import EMBEDDED, EMBEDDING, PREFIX, Policy, image_input

CHANNELS = (16, 24, 48, 64, 96, 128)
"""Of convolutions, each of which halves the picture; one of 64 rows or fewer needs no first one."""
LOW = 64  # [px]
HIDDEN = 256


class Network(nn.Module):
    """Pictures (N, 3, H, W) 0 to 1 and embeddings (N, 64) to normalised actions (N, chunk, numbers).

    With a prefix, it also takes so many of the chunk's first actions (N, prefix, numbers + 1), of which the last number
    is 1 where an action is committed already, else all are 0 (Black et al. 2025, real-time chunking in training).
    """

    def __init__(self, height: int, width: int, chunk: int, numbers: int, prefix: int = 0) -> None:
        super().__init__()
        self.chunk, self.numbers, self.prefix = chunk, numbers, prefix
        layers = CHANNELS if height > LOW else CHANNELS[1:]
        self.convolutions = nn.ModuleList(
            nn.Conv2d(inputs, outputs, 3, 2, 1) for inputs, outputs in zip((3, *layers), layers, strict=False)
        )
        self.scales = nn.ModuleList(nn.Linear(EMBEDDING, channels) for channels in layers[1:])
        self.shifts = nn.ModuleList(nn.Linear(EMBEDDING, channels) for channels in layers[1:])
        for _ in layers:
            height, width = (height + 1) // 2, (width + 1) // 2
        self.hidden = nn.Linear(CHANNELS[-1] * height * width + prefix * (numbers + 1), HIDDEN)
        self.head = nn.Linear(HIDDEN, chunk * numbers)

    def forward(self, pictures: Tensor, embeddings: Tensor, prefix: Tensor | None = None) -> Tensor:
        """See the class."""
        x = torch.relu(self.convolutions[0](pictures))
        for convolution, scale, shift in zip(self.convolutions[1:], self.scales, self.shifts, strict=True):
            factors, terms = (values[:, :, None, None] for values in (1.0 + scale(embeddings), shift(embeddings)))
            x = torch.relu(torch.addcmul(terms, convolution(x), factors))
        x = x.flatten(1)
        if prefix is not None:
            x = torch.cat([x, prefix.flatten(1)], 1)
        x = self.head(torch.relu(self.hidden(x)))
        return x.reshape(-1, self.chunk, self.numbers)


def to_onnx(network: Network, policy: Policy) -> bytes:
    """The same network as an ONNX graph with the inputs and outputs of a policy."""
    from onnx import TensorProto, helper, numpy_helper

    weights: list[Any] = []
    nodes: list[Any] = []

    def node(kind: str, inputs: list[str], output: str, **attributes: Any) -> str:
        nodes.append(helper.make_node(kind, inputs, [output], name=output, **attributes))
        return output

    def weight(name: str, values: Tensor) -> str:
        weights.append(numpy_helper.from_array(values.detach().numpy(), name))
        return name

    def linear(layer: nn.Linear, name: str, x: str, plus: float = 0.0) -> str:
        inputs = [x, weight(f"{name}.weight", layer.weight), weight(f"{name}.bias", layer.bias + plus)]
        return node("Gemm", inputs, name, transB=1)

    picture, embedding = image_input(policy.cameras[0].name), EMBEDDED
    x = picture
    for i, convolution in enumerate(network.convolutions):
        assert isinstance(convolution, nn.Conv2d)
        inputs = [x, weight(f"convolution_{i}.weight", convolution.weight)]
        inputs.append(weight(f"convolution_{i}.bias", convolution.bias))
        x = node("Conv", inputs, f"convolution_{i}", strides=[2, 2], pads=[1, 1, 1, 1])
        if i > 0:
            shape = weight(f"shape_{i}", torch.tensor([1, convolution.out_channels, 1, 1]))
            factors = linear(network.scales[i - 1], f"scale_{i}", embedding, plus=1.0)
            terms = linear(network.shifts[i - 1], f"shift_{i}", embedding)
            x = node("Mul", [x, node("Reshape", [factors, shape], f"scale_{i}_wide")], f"scaled_{i}")
            x = node("Add", [x, node("Reshape", [terms, shape], f"shift_{i}_wide")], f"shifted_{i}")
        x = node("Relu", [x], f"features_{i}")
    x = node("Flatten", [x], "flat")
    if network.prefix:
        x = node("Concat", [x, node("Flatten", [PREFIX], "prefix")], "flat_with_prefix", axis=1)
    x = node("Relu", [linear(network.hidden, "hidden", x)], "hidden_features")
    shape = weight("shape_of_actions", torch.tensor([1, network.chunk, network.numbers]))
    node("Reshape", [linear(network.head, "head", x), shape], "action")

    def values(shapes: dict[str, tuple[int, ...]]) -> list[Any]:
        return [helper.make_tensor_value_info(name, TensorProto.FLOAT, list(s)) for name, s in shapes.items()]

    graph = helper.make_graph(nodes, "policy", values(policy.inputs()), values(policy.outputs()), weights)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    return bytes(model.SerializeToString())
