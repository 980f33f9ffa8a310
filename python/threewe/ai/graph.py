"""ONNX graphs of policies: only plain layers of sizes that are known beforehand, with all weights in the one file."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from threewe._extras import needed_for
from threewe.errors import ConfigError

if TYPE_CHECKING:
    import onnx

MOST_NUMBERS = 2**24
"""Of one tensor."""
MOST_NODES = 10_000
ALLOWED = {
    *("Add", "AveragePool", "BatchNormalization", "Cast", "Clip", "Concat", "Constant", "Conv", "DequantizeLinear"),
    *("Div", "Elu", "Erf", "Exp", "Flatten", "Gather", "Gelu", "Gemm", "GlobalAveragePool", "HardSwish", "Identity"),
    *("LayerNormalization", "LeakyRelu", "MatMul", "MaxPool", "Mul", "Neg", "Pow", "QuantizeLinear", "ReduceMean"),
    *("Relu", "Reshape", "Shape", "Sigmoid", "Slice", "Softmax", "Softplus", "Split", "Sqrt", "Squeeze", "Sub"),
    *("Tanh", "Transpose", "Unsqueeze"),
}
"""Operators that can neither loop, nor draw, nor make a size out of data."""

Shapes = dict[str, tuple[int, ...]]


def check_graph(path: Path, inputs: Shapes, outputs: Shapes) -> None:
    """Checks a graph without running it. Raises ConfigError with the file and what is wrong."""
    with needed_for("loading a policy", "policy"):
        import onnx
    try:
        model = onnx.load(str(path), load_external_data=False)
    except Exception as error:  # protobuf has its own
        raise ConfigError(f"{path}: no ONNX graph: {error}") from None
    if wrong := next(_mistakes(model, inputs, outputs), None):
        raise ConfigError(f"{path}: {wrong}")


def _mistakes(model: onnx.ModelProto, inputs: Shapes, outputs: Shapes) -> Iterator[str]:
    graph = model.graph
    if not graph.node:
        yield "a graph without nodes"
    if len(graph.node) > MOST_NODES:
        yield f"{len(graph.node)} nodes; at most {MOST_NODES} are read"
    for opset in model.opset_import:
        if opset.domain not in ("", "ai.onnx"):
            yield f"operators of the domain {opset.domain!r}: only ONNX's own are run"
    if model.functions:
        yield f"function {model.functions[0].name!r}: functions are not run"
    if graph.sparse_initializer:
        yield "sparse weights are not read"
    for node in graph.node:
        yield from _mistakes_of_node(node)
    for tensor in graph.initializer:
        yield from _mistakes_of_tensor(f"weight {tensor.name!r}", tensor)
    yield from _mistakes_of_names(graph)
    yield from _compared("input", _shapes(graph.input, {t.name for t in graph.initializer}), inputs)
    yield from _compared("output", _shapes(graph.output, set()), outputs)
    yield from _mistakes_of_sizes(model)


def _mistakes_of_node(node: onnx.NodeProto) -> Iterator[str]:
    name = f"node {node.name or node.op_type!r}"
    if node.domain not in ("", "ai.onnx"):
        yield f"{name}: operator {node.op_type!r} of the domain {node.domain!r}: only ONNX's own are run"
    if node.op_type not in ALLOWED:
        yield f"{name}: operator {node.op_type!r} is not one that policies may use"
    for attribute in node.attribute:
        if attribute.HasField("g") or attribute.graphs:
            yield f"{name}: a graph inside of a graph is not run"
        for tensor in (*([attribute.t] if attribute.HasField("t") else []), *attribute.tensors):
            yield from _mistakes_of_tensor(f"{name}, attribute {attribute.name!r}", tensor)


def _mistakes_of_names(graph: onnx.GraphProto) -> Iterator[str]:
    """Whatever is read has been given once, and no weight is left over."""
    weights = {tensor.name for tensor in graph.initializer}
    given, used = weights | {value.name for value in graph.input}, {value.name for value in graph.output}
    if len(weights) < len(graph.initializer):
        yield "two weights have one name"
    for node in graph.node:
        for name in filter(None, node.input):
            if name not in given:
                yield f"node {node.name or node.op_type!r}: {name!r} is missing"
            used.add(name)
        for name in filter(None, node.output):
            if name in given:
                yield f"node {node.name or node.op_type!r}: {name!r} is given twice"
            given.add(name)
    if extra := sorted(weights - used):
        yield f"weight {extra[0]!r} is used nowhere"


def _mistakes_of_tensor(name: str, tensor: onnx.TensorProto) -> Iterator[str]:
    import onnx

    if tensor.data_location == onnx.TensorProto.EXTERNAL or tensor.external_data:
        where = next((entry.value for entry in tensor.external_data if entry.key == "location"), "")
        yield f"{name}: its numbers are in another file, {where!r}: save them inside of the graph"
    if any(length < 0 for length in tensor.dims) or math.prod(tensor.dims) > MOST_NUMBERS:
        yield f"{name}: of shape {tuple(tensor.dims)}; at most {MOST_NUMBERS} numbers are read"
    if tensor.data_type == onnx.TensorProto.STRING:
        yield f"{name}: text is not read"
    try:
        numbers = onnx.numpy_helper.to_array(tensor)
    except (ValueError, TypeError, KeyError) as error:
        yield f"{name}: {error}"
        return
    if not np.isfinite(numbers.astype(np.float64)).all():
        yield f"{name}: NaN or infinite"


def _shapes(values: Any, weights: set[str]) -> Shapes:
    """Of inputs or outputs; what is no float32 tensor of a fixed size has the shape (-1,)."""
    found = {}
    for value in values:
        if value.name in weights:
            continue
        tensor = value.type.tensor_type
        fixed = tensor.elem_type == 1 and all(d.HasField("dim_value") for d in tensor.shape.dim)
        found[value.name] = tuple(d.dim_value for d in tensor.shape.dim) if fixed else (-1,)
    return found


def _compared(what: str, has: Shapes, wanted: Shapes) -> Iterator[str]:
    """Both sides, where they differ."""
    if has != wanted:

        def listed(shapes: Shapes) -> str:
            texts = ("no float32 of a fixed size" if s == (-1,) else "x".join(map(str, s)) for s in shapes.values())
            return ", ".join(f"{name} ({text})" for name, text in zip(shapes, texts, strict=True)) or "none"

        yield f"{what}s do not fit policy.json: the graph has {listed(has)}; policy.json says {listed(wanted)}"


def _mistakes_of_sizes(model: onnx.ModelProto) -> Iterator[str]:
    """What is computed on the way must have sizes that are known and bounded."""
    import onnx

    try:
        inferred = onnx.shape_inference.infer_shapes(model, strict_mode=True, data_prop=True)
    except Exception as error:
        yield f"its sizes do not fit: {str(error).splitlines()[0]}"
        return
    known = {value.name: value for value in (*inferred.graph.value_info, *inferred.graph.output)}
    for node in inferred.graph.node:
        for name in filter(None, node.output):
            shape = known[name].type.tensor_type.shape.dim if name in known else None
            if shape is None or not all(d.HasField("dim_value") for d in shape):
                yield f"node {node.name or node.op_type!r}: the size of {name!r} is not fixed"
            elif math.prod(d.dim_value for d in shape) > MOST_NUMBERS:
                yield f"node {node.name or node.op_type!r}: {name!r} has more than {MOST_NUMBERS} numbers"
