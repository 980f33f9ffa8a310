"""Folders of policies for tests: small graphs that do what one can foresee."""

from __future__ import annotations

import copy
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper
from threewe.ai import Policy

IMAGE, TEXT = "observation.images.camera", "observation.environment_state"
HEIGHT, WIDTH, CHUNK = 12, 16, 10

DESCRIPTION: dict[str, Any] = {
    "format": "3we-policy",
    "version": 1,
    "kinematics": "holonomic",
    "cameras": [{"name": "camera", "height": HEIGHT, "width": WIDTH, "color": "rgb"}],
    "state": [],
    "action": [
        {"name": n, "unit": "rad/s" if n == "omega" else "m/s", "mean": 0.0, "std": 1.0} for n in ("vx", "vy", "omega")
    ],
    "rate": 10,
    "chunk": CHUNK,
    "latency": 0.1,
    "merge": "blend",
    "language": True,
    "training": {"dataset": "none"},
}


def description(**changes: Any) -> dict[str, Any]:
    """A right `policy.json`, but for changes."""
    return {**copy.deepcopy(DESCRIPTION), **changes}


def graph(
    velocity: tuple[float, float, float] = (0.2, 0.0, 0.0), red: float = 0.0, chunk: int = CHUNK, prefix: int = 0
) -> onnx.ModelProto:
    """Always the same velocity, plus `red` times the mean of the first channel [m/s] ahead; a prefix is ignored."""
    ahead = np.zeros((3, chunk * 3), np.float32)
    ahead[0, ::3] = red
    weights = {
        "ahead": ahead,
        "always": np.tile(np.array(velocity, np.float32), chunk)[None],
        "ignored": np.zeros((64, chunk * 3), np.float32),
    }
    nodes = [
        helper.make_node("GlobalAveragePool", [IMAGE], ["pooled"]),
        helper.make_node("Flatten", ["pooled"], ["channels"]),
        helper.make_node("Gemm", ["channels", "ahead", "always"], ["seen"]),
        helper.make_node("MatMul", [TEXT, "ignored"], ["heard"]),
        helper.make_node("Add", ["seen", "heard"], ["flat"]),
        helper.make_node("Reshape", ["flat", "shape"], ["action"]),
    ]
    inputs = [
        helper.make_tensor_value_info(IMAGE, TensorProto.FLOAT, [1, 3, HEIGHT, WIDTH]),
        helper.make_tensor_value_info(TEXT, TensorProto.FLOAT, [1, 64]),
    ]
    if prefix:
        weights["forgotten"] = np.zeros((4 * prefix, chunk * 3), np.float32)
        nodes[4:5] = [
            helper.make_node("Flatten", ["action.prefix"], ["given"]),
            helper.make_node("MatMul", ["given", "forgotten"], ["none"]),
            helper.make_node("Add", ["seen", "none"], ["before"]),
            helper.make_node("Add", ["before", "heard"], ["flat"]),
        ]
        inputs.append(helper.make_tensor_value_info("action.prefix", TensorProto.FLOAT, [1, prefix, 4]))
    initializers = [numpy_helper.from_array(array, name) for name, array in weights.items()]
    initializers.append(numpy_helper.from_array(np.array([1, chunk, 3]), "shape"))
    return helper.make_model(
        helper.make_graph(
            nodes,
            "test",
            inputs,
            [helper.make_tensor_value_info("action", TensorProto.FLOAT, [1, chunk, 3])],
            initializers,
        ),
        opset_imports=[helper.make_opsetid("", 17)],
        ir_version=10,
    )


def write(folder: Path, model: onnx.ModelProto | None = None, **changes: Any) -> Path:
    """The folder of a policy."""
    folder.mkdir(exist_ok=True)
    (folder / "policy.json").write_text(json.dumps(description(**changes)))
    (folder / "model.onnx").write_bytes((model or graph()).SerializeToString())
    return folder


def moved(policy: Policy, folder: Path) -> Policy:
    """The same in another folder."""
    return replace(policy, folder=folder)
