"""Cuts a policy's graph in two: an encoder of convolutions for Hailo's compiler, and the head that runs here."""

from __future__ import annotations

import math
import stat
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from threewe._extras import needed_for
from threewe.ai.calibration import Feed
from threewe.ai.folder import ENCODER, FEATURES, GRAPH, HEAD, Policy, image_input, write_description
from threewe.ai.graph import Shapes
from threewe.errors import ConfigError

if TYPE_CHECKING:
    import onnx

ENCODED = {"Conv", "Relu", "MaxPool", "AveragePool", "Add", "Concat"}
"""Operators of an encoder."""
LEAST_SHARE = 0.5
"""Of a policy's multiplications in convolutions, in its encoder: with less, a Hailo is of no use."""
NORMALIZED = "picture"
"""The encoder's input, normalised."""
SOURCE, PICTURES, SCRIPT, COMMANDS = "encoder.onnx", "calibration.npy", "encoder.alls", "compile.sh"
POLICY = "policy"
"""Folder with policy.json and head.onnx, that lacks encoder.hef."""


@dataclass
class Cut:
    """Two graphs, and what is done to a picture before the first: (pixel - mean) / std, of 0 to 255."""

    encoder: onnx.ModelProto
    head: onnx.ModelProto
    mean: list[float]
    std: list[float]
    features: tuple[int, int, int]
    """shape of what is passed from one to the other"""


def write_for_hailo(policy: Policy, feeds: Sequence[Feed], output: Path, arch: str) -> None:
    """Writes what Hailo's compiler takes, and the policy's folder, into which its encoder.hef goes. ConfigError."""
    if output.exists():
        raise ConfigError(f"output: {output} exists already")
    cut = cut_graph(policy)
    picture = image_input(policy.cameras[0].name)
    pixels = np.stack([np.rint(feed[picture][0].transpose(1, 2, 0) * 255).astype(np.uint8) for feed in feeds])
    output.mkdir(parents=True)
    (output / SOURCE).write_bytes(cut.encoder.SerializeToString())
    np.save(output / PICTURES, pixels)
    (output / SCRIPT).write_text(f"normalization1 = normalization({cut.mean}, {cut.std})\n", encoding="utf-8")
    (output / COMMANDS).write_text(_commands(arch), encoding="utf-8")
    (output / COMMANDS).chmod((output / COMMANDS).stat().st_mode | stat.S_IXUSR)
    (output / POLICY).mkdir()
    write_description(replace(policy, folder=output / POLICY, features=cut.features))
    (output / POLICY / HEAD).write_bytes(cut.head.SerializeToString())


def _commands(arch: str) -> str:
    return f"""#!/bin/sh
# Makes encoder.hef with Hailo's Dataflow Compiler 3.x (of Hailo's developer zone, x86-64).
set -e
hailo parser onnx {SOURCE} --hw-arch {arch} --net-name encoder --har-path encoder.har -y
hailo optimize encoder.har --hw-arch {arch} --calib-set-path {PICTURES} --model-script {SCRIPT} \\
  --output-har-path encoder_quantized.har
hailo compiler encoder_quantized.har --hw-arch {arch} --output-dir .
mv encoder.hef {POLICY}/{ENCODER}
"""


def cut_graph(policy: Policy) -> Cut:
    """Cuts where the last convolution that sees nothing but the picture ends. Raises ConfigError."""
    with needed_for("cutting a policy", "policy"):
        import onnx

    path = policy.folder / GRAPH
    if len(policy.cameras) != 1:
        raise ConfigError(f"{path}: {len(policy.cameras)} cameras; an encoder takes the picture of one")
    camera, picture = policy.cameras[0], image_input(policy.cameras[0].name)
    parts = _Parts(onnx.load(str(path)))
    scaled, first, (scale, offset) = parts.normalization(picture)
    encoded, inside = parts.convolutions(scaled)
    rest = [node for node in parts.nodes if node not in encoded and node not in first]
    passed = sorted({each for node in rest for each in node.input if each in inside})
    share = parts.work(encoded) / max(1.0, parts.work(parts.nodes))
    if share < LEAST_SHARE:
        raise ConfigError(
            f"{path}: {100 * share:.0f} % of its convolutions see the picture alone, before the instruction or the "
            "state comes in: too little for a Hailo; LeRobot's ACT can be cut"
        )
    if len(passed) != 1 or passed == [scaled]:
        raise ConfigError(f"{path}: {len(passed)} tensors leave its convolutions; an encoder gives one")
    (last,) = passed
    others = {name: shape for name, shape in policy.inputs().items() if name != picture}
    names = {scaled: NORMALIZED, last: FEATURES}
    _, channels, height, width = shape = parts.shapes[last]
    return Cut(
        parts.graph_of(encoded, {NORMALIZED: (1, 3, camera.height, camera.width)}, {FEATURES: shape}, names),
        parts.graph_of(rest, {FEATURES: shape, **others}, policy.outputs(), names),
        # p / 255 * scale + offset = (p - mean) / std
        [round(float(x), 6) for x in -offset * 255 / scale],
        [round(float(x), 6) for x in 255 / scale],
        (channels, height, width),
    )


class _Parts:
    """A graph, of which parts are made graphs of their own."""

    def __init__(self, model: onnx.ModelProto) -> None:
        import onnx

        self.model, self.nodes = model, list(model.graph.node)
        self.weights = {tensor.name: tensor for tensor in model.graph.initializer}
        known = onnx.shape_inference.infer_shapes(model, strict_mode=True, data_prop=True).graph.value_info
        self.shapes = {value.name: tuple(d.dim_value for d in value.type.tensor_type.shape.dim) for value in known}

    def normalization(
        self, picture: str
    ) -> tuple[str, list[onnx.NodeProto], tuple[NDArray[np.float64], NDArray[np.float64]]]:
        """What the first layer takes, the nodes that make it of a picture, and by which factor and offset they do."""
        from onnx import numpy_helper

        scale, offset, name = np.ones(3), np.zeros(3), picture
        before: list[onnx.NodeProto] = []
        while True:
            users = [node for node in self.nodes if name in node.input]
            node = users[0]
            if len(users) > 1 or node.op_type not in ("Sub", "Mul", "Add", "Div") or node.input[1] not in self.weights:
                return name, before, (scale, offset)
            number = np.broadcast_to(numpy_helper.to_array(self.weights[node.input[1]]).reshape(-1), 3).astype(float)
            if node.op_type in ("Sub", "Add"):
                offset = offset + number * (1 if node.op_type == "Add" else -1)
            else:
                factor = number if node.op_type == "Mul" else 1 / number
                scale, offset = scale * factor, offset * factor
            before.append(node)
            name = node.output[0]

    def convolutions(self, start: str) -> tuple[list[onnx.NodeProto], set[str]]:
        """The nodes that follow from a tensor alone, by operators that an encoder has, and what they give."""
        encoded, inside = [], {start}
        for node in self.nodes:
            sources = [name for name in node.input if name and name not in self.weights]
            if node.op_type in ENCODED and sources and inside.issuperset(sources):
                encoded.append(node)
                inside.update(node.output)
        return encoded, inside

    def work(self, nodes: Sequence[onnx.NodeProto]) -> float:
        """Multiplications in convolutions."""
        work = 0.0
        for node in nodes:
            if node.op_type == "Conv":
                work += math.prod(self.weights[node.input[1]].dims[1:]) * math.prod(self.shapes[node.output[0]])
        return work

    def graph_of(
        self, nodes: Sequence[onnx.NodeProto], inputs: Shapes, outputs: Shapes, names: dict[str, str]
    ) -> onnx.ModelProto:
        """Some nodes with the weights that they use; tensors get other names."""
        import onnx
        from onnx import TensorProto, helper

        def values(shapes: Shapes) -> list[onnx.ValueInfoProto]:
            return [helper.make_tensor_value_info(name, TensorProto.FLOAT, list(s)) for name, s in shapes.items()]

        renamed = []
        for node in nodes:
            copy = onnx.NodeProto()
            copy.CopyFrom(node)
            copy.input[:] = [names.get(each, each) for each in node.input]
            copy.output[:] = [names.get(each, each) for each in node.output]
            renamed.append(copy)
        used = dict.fromkeys(each for node in nodes for each in node.input if each in self.weights)
        graph = helper.make_graph(renamed, "policy", values(inputs), values(outputs), [self.weights[n] for n in used])
        return helper.make_model(graph, opset_imports=self.model.opset_import, ir_version=self.model.ir_version)
