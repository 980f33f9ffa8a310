"""Folders that are no policy, or would run code: each is one error with file and field, and nothing of it is run."""

from __future__ import annotations

import json
import pickle
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import pytest
from ai import policies
from onnx import TensorProto, helper, numpy_helper
from threewe import ConfigError
from threewe.ai import read_policy


def changed(change: Callable[[onnx.ModelProto], object]) -> onnx.ModelProto:
    model = policies.graph()
    change(model)
    return model


def external(model: onnx.ModelProto, location: str) -> None:
    tensor = model.graph.initializer[0]
    tensor.ClearField("raw_data")
    tensor.data_location = TensorProto.EXTERNAL
    tensor.external_data.add(key="location", value=location)


def huge(model: onnx.ModelProto) -> None:
    del model.graph.initializer[0].dims[:]
    model.graph.initializer[0].dims.extend([2**30, 2**30])


def looping(model: onnx.ModelProto) -> None:
    body = helper.make_graph([helper.make_node("Identity", ["a"], ["b"])], "body", [], [])
    model.graph.node.append(helper.make_node("Loop", ["shape"], ["x"], body=body))


def wide(model: onnx.ModelProto) -> None:
    """Convolutions that pad a small picture to a large one."""
    weight = numpy_helper.from_array(np.zeros((1, 3, 1, 1), np.float32), "w")
    model.graph.initializer.append(weight)
    model.graph.node.insert(0, helper.make_node("Conv", [policies.IMAGE, "w"], ["wide"], pads=[2**20] * 4))


def renamed_weight(model: onnx.ModelProto) -> None:
    model.graph.initializer[0].name = "other"


GRAPHS: list[tuple[str, Callable[[onnx.ModelProto], object], str]] = [
    ("external", lambda m: external(m, "weights.data"), "weight 'ahead': its numbers are in another file"),
    ("traversal", lambda m: external(m, "../../etc/passwd"), r"in another file, '\.\./\.\./etc/passwd'"),
    ("domain", lambda m: m.opset_import.add(domain="com.microsoft", version=1), "domain 'com.microsoft'"),
    ("node_domain", lambda m: setattr(m.graph.node[0], "domain", "evil"), "of the domain 'evil'"),
    ("operator", lambda m: setattr(m.graph.node[0], "op_type", "RandomNormalLike"), "'RandomNormalLike' is not one"),
    ("huge", huge, "weight 'ahead': of shape"),
    ("loop", looping, "operator 'Loop' is not one"),
    ("wide", wide, "'wide' has more than 16777216 numbers"),
    ("function", lambda m: m.functions.add(name="f", domain="evil"), "function 'f'"),
    (
        "nan",
        lambda m: m.graph.initializer[0].CopyFrom(
            numpy_helper.from_array(np.full((3, 30), np.nan, np.float32), "ahead")
        ),
        "weight 'ahead': NaN or infinite",
    ),
    ("empty", lambda m: m.graph.ClearField("node"), "a graph without nodes"),
    ("missing", renamed_weight, "'ahead' is missing"),
    ("missing_bias", lambda m: m.graph.initializer.pop(1), "'always' is missing"),
    ("extra", lambda m: m.graph.initializer.add(name="more", data_type=1, dims=[0]), "weight 'more' is used nowhere"),
    ("doubled", lambda m: m.graph.initializer.append(m.graph.initializer[0]), "two weights have one name"),
    ("twice", lambda m: m.graph.node.append(m.graph.node[0]), "'pooled' is given twice"),
    (
        "dynamic",
        lambda m: m.graph.input[0].type.tensor_type.shape.dim[0].ClearField("value"),
        "observation.images.camera .no float32 of a fixed size.*policy.json says observation.images.camera .1x3x12x16",
    ),
]


@pytest.mark.parametrize(("name", "change", "message"), GRAPHS, ids=[name for name, _, _ in GRAPHS])
def test_graphs(tmp_path: Path, name: str, change: Callable[[onnx.ModelProto], object], message: str) -> None:
    folder = policies.write(tmp_path / name, changed(change))
    with pytest.raises(ConfigError, match=message) as refusal:
        read_policy(folder)
    assert str(folder / "model.onnx") in str(refusal.value)


def test_bytes_that_are_no_graph(tmp_path: Path) -> None:
    folder = policies.write(tmp_path / "policy")
    (folder / "model.onnx").write_bytes(b"\xff" * 100)
    with pytest.raises(ConfigError, match=r"model\.onnx: no ONNX graph"):
        read_policy(folder)


CAMERA = policies.DESCRIPTION["cameras"][0]
ACTION = policies.DESCRIPTION["action"]
FIELDS: list[tuple[dict[str, Any], str]] = [
    ({"version": 2}, "version: 2 is newer than 1"),
    ({"version": True}, "version: must be a whole number"),
    ({"format": "lerobot"}, "format: must be one of 3we-policy"),
    ({"kinematics": "legged"}, "kinematics: must be one of holonomic, differential"),
    ({"kinematics": "differential"}, "action: a differential base has no 'vy'"),
    ({"extra": 1}, "extra: is not a field that policies have"),
    ({"cameras": []}, "cameras: must be a list of 1 to 4"),
    ({"cameras": [{**CAMERA, "name": "front"}]}, r"model\.onnx: inputs do not fit .* policy\.json says .*front"),
    ({"cameras": [{**CAMERA, "name": "../x"}]}, r"cameras\[0\]\.name: must be letters, digits and '_', got '\.\./x'"),
    ({"cameras": [CAMERA, CAMERA]}, "cameras: a name stands twice: camera, camera"),
    ({"cameras": [{**CAMERA, "color": "hsv"}]}, r"cameras\[0\]\.color: must be one of rgb, bgr"),
    ({"cameras": [{**CAMERA, "height": 10**9}]}, r"cameras\[0\]\.height: must be a whole number"),
    ({"cameras": [{**CAMERA, "height": 24}]}, "the graph has .*1x3x12x16.*policy.json says .*1x3x24x16"),
    ({"cameras": [3]}, r"cameras\[0\]\.? must be an object"),
    ({"action": [{**ACTION[0], "name": "theta.vel"}]}, r"action\[0\]\.name: must be one of vx, vy, omega"),
    ({"action": [{**ACTION[0], "unit": "km/h"}]}, r"action\[0\]\.unit: must be one of m/s"),
    ({"action": ACTION[:2]}, "the graph has action .1x10x3.; policy.json says action .1x10x2."),
    ({"action": [ACTION[0], ACTION[0]]}, "action: a name stands twice: vx, vx"),
    ({"action": [{**ACTION[0], "std": 0}]}, r"action\[0\]\.std: must be a number"),
    ({"action": [{**ACTION[0], "mean": float("nan")}]}, r"action\[0\]\.mean: must be a number"),
    ({"state": ACTION}, "policy.json says .*observation.state .1x3."),
    ({"rate": 1000}, "rate: must be a number in"),
    ({"chunk": 1}, "chunk: must be a whole number in"),
    ({"latency": -1}, "latency: must be a number in"),
    ({"merge": "average"}, "merge: must be one of replace, blend, ensemble"),
    ({"language": "yes"}, "language: must be true or false"),
    ({"language": False}, "the graph has .*environment_state"),
    ({"training": {"epochs": 3}}, r"training\.epochs: must be a text"),
]


@pytest.mark.parametrize(("changes", "message"), FIELDS)
def test_fields(tmp_path: Path, changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        read_policy(policies.write(tmp_path / "policy", **changes))


@pytest.mark.parametrize("field", list(policies.DESCRIPTION))
def test_missing_fields(tmp_path: Path, field: str) -> None:
    folder = policies.write(tmp_path / "policy")
    content = policies.description()
    del content[field]
    (folder / "policy.json").write_text(json.dumps(content))
    with pytest.raises(ConfigError, match=f"{field}: is missing"):
        read_policy(folder)


@pytest.mark.parametrize("text", ["", "{", "[" * 100_000, "[]", "1e999", '{"version": 1, "version": 1}', "\udcff"])
def test_no_description(tmp_path: Path, text: str) -> None:
    folder = policies.write(tmp_path / "policy")
    (folder / "policy.json").write_bytes(text.encode("utf-8", "surrogateescape"))
    with pytest.raises(ConfigError, match=r"policy\.json"):
        read_policy(folder)


class Bomb:
    def __reduce__(self) -> Any:
        return Path.touch, (Path("run"),)


@pytest.mark.parametrize(
    "name", ["model.pt", "model.pth", "model.bin", "model.ckpt", "model.pkl", "weights", "notes.txt"]
)
@pytest.mark.parametrize("kind", ["pickle", "zip"])
def test_pickle_is_refused_under_any_name(
    tmp_path: Path, name: str, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    folder = policies.write(tmp_path / "policy")
    if kind == "pickle":
        (folder / name).write_bytes(pickle.dumps(Bomb()))
    else:  # as PyTorch and TorchScript write
        with zipfile.ZipFile(folder / name, "w") as archive:
            archive.writestr("archive/data.pkl", pickle.dumps(Bomb()))
    with pytest.raises(ConfigError, match=f"{name}: pickled"):
        read_policy(folder)
    with pytest.raises(ConfigError, match=f"{name}: pickled"):
        read_policy(folder / name)
    assert not (tmp_path / "run").exists()


def test_links_and_missing_files(tmp_path: Path) -> None:
    folder = policies.write(tmp_path / "policy")
    (tmp_path / "elsewhere.onnx").write_bytes((folder / "model.onnx").read_bytes())
    (folder / "model.onnx").unlink()
    with pytest.raises(ConfigError, match=r"model\.onnx: no such file"):
        read_policy(folder)
    (folder / "model.onnx").symlink_to(tmp_path / "elsewhere.onnx")
    with pytest.raises(ConfigError, match=r"model\.onnx: a link out of the policy's folder"):
        read_policy(folder)
    with pytest.raises(ConfigError, match="no such folder"):
        read_policy(tmp_path / "nothing")
