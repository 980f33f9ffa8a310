"""Detectors of one's own: what an ONNX graph finds is on the robot's map of things, and what is none is one error."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from threewe import ConfigError, Robot, sync
from threewe._own_detector import load_detector

onnx = pytest.importorskip("onnx", reason="not shown: onnx is not installed")
pytest.importorskip("onnxruntime", reason="not shown: onnxruntime is not installed")

LAYOUT = """\
version: 1
labels:
  - {kind: chair, radius: 0.3}
  - "-"
  - {kind: plant, radius: 0.25}
"""
BOXES = [[100.0, 60.0, 40.0, 60.0, 0.1, 0.0, 0.9], [102.0, 61.0, 40.0, 60.0, 0.2, 0.0, 0.8],
         [20.0, 30.0, 16.0, 16.0, 0.6, 0.0, 0.1], [60.0, 30.0, 30.0, 30.0, 0.1, 0.9, 0.2],
         [60.0, 90.0, 30.0, 30.0, 0.1, 0.0, 0.2]]  # fmt: skip


def graph(path: Path, boxes: Any = None, shape: tuple[Any, ...] = (1, 3, 120, 160), type_: int = 1) -> Path:
    """A network that finds the same boxes in every picture: its input times zero, plus them."""
    from onnx import TensorProto, helper, numpy_helper

    values = np.array(BOXES if boxes is None else boxes, np.float32)[None]
    nodes = [
        helper.make_node("Cast", ["picture"], ["float"], to=TensorProto.FLOAT),
        helper.make_node("ReduceMax", ["float"], ["largest"], keepdims=0),
        helper.make_node("Mul", ["largest", "zero"], ["nothing"]),
        helper.make_node("Add", ["boxes", "nothing"], ["found"]),
    ]
    weights = [numpy_helper.from_array(values, "boxes"), numpy_helper.from_array(np.float32(0.0), "zero")]
    inputs = [helper.make_tensor_value_info("picture", type_, shape)]
    outputs = [helper.make_tensor_value_info("found", TensorProto.FLOAT, values.shape)]
    made = helper.make_model(
        helper.make_graph(nodes, "boxes", inputs, outputs, weights),
        opset_imports=[helper.make_opsetid("", 13)],
        ir_version=8,
    )
    onnx.save(made, str(path))
    return path


@pytest.fixture
def mine(tmp_path: Path) -> Path:
    (tmp_path / "mine.yaml").write_text(LAYOUT)
    return graph(tmp_path / "mine.onnx")


@pytest.mark.parametrize("way", ["rows", "columns", "last", "bytes", "corners"])
def test_boxes_become_things_with_bearing_distance_and_color(mine: Path, way: str) -> None:
    boxes = np.array(BOXES)
    if way == "columns":
        graph(mine, boxes.T)
    elif way == "last":
        graph(mine, shape=(1, 120, 160, 3))
    elif way == "bytes":
        graph(mine, type_=onnx.TensorProto.UINT8)
    elif way == "corners":
        boxes[:, :2] -= boxes[:, 2:4] / 2
        boxes[:, 2:4] += boxes[:, :2]
        graph(mine, boxes)
        mine.with_suffix(".yaml").write_text(LAYOUT + "boxes: corners\n")
    camera = Robot().profile.camera
    assert camera is not None
    detector = load_detector(str(mine))
    assert detector.labels == ["background", "chair", "plant"]
    assert detector.radii == [0.0, 0.3, 0.25]
    picture = np.full((480, 640, 3), 128, np.uint8)
    picture[120:360, 320:480] = (0, 0, 200)  # BGR
    plant, chair = detector.detect(picture, camera.intrinsics)
    assert (detector.labels[plant.kind_index], plant.color, plant.colors) == ("plant", "red", {"red": 1.0})
    assert list(plant.box) == [320, 120, 480, 360]
    assert plant.confidence == pytest.approx(0.9 * 0.9, abs=0.01)
    assert sum(plant.scores) == pytest.approx(1.0)
    fx, cx = camera.intrinsics.fx, camera.intrinsics.cx
    assert plant.bearing == pytest.approx(-np.arctan((400 - cx) / fx), abs=1e-6)
    assert plant.distance == pytest.approx(2 * 0.25 * fx / 160)
    assert (detector.labels[chair.kind_index], chair.color) == ("chair", "gray")
    assert chair.cells < plant.cells


def test_a_robot_uses_it_as_the_one_that_ships(mine: Path, tmp_path: Path) -> None:
    with sync.Robot(scene="corridor_v1", detector=mine) as robot:
        result = robot.execute_instruction("move forward 60 cm, then turn left 25 degrees, then list things")
        assert result.labels == ("background", "chair", "plant")
        assert "plant" in result.answer
        assert {kind for kind, _, _ in result.steps[0].seen} == {"plant", "chair"}
        result.save(tmp_path / "run.html")
        found = robot.execute_instruction("find the desk", timeout=60.0)
        assert (found.success, found.reason) == (False, "not_found")
        assert "unknown kind" in found.detail
    with sync.Robot(scene="corridor_v1") as robot:
        assert "desk" in robot.execute_instruction("wait 1 second").labels


@pytest.mark.parametrize(
    ("layout", "says"),
    [
        (None, r"mine\.onnx needs its labels and layout next to it, in mine\.yaml"),
        ("", r"mine\.yaml"),
        ("version: 2\nlabels: []\n", r"mine\.yaml:1: version"),
        ("version: 1\nlabels: chair\n", r"mine\.yaml:2: labels"),
        ("version: 1\nlabels: []\n", r"mine\.yaml:2: labels: expected one kind or more"),
        ("version: 1\nlabels: [chair]\n", r"mine\.yaml:2: labels.*expected {kind: NAME, radius: METRES}"),
        (LAYOUT.replace("0.3", "big"), r"mine\.yaml:3: .*radius"),
        (LAYOUT.replace("0.3", "-1"), r"mine\.yaml:3: .*radius"),
        (LAYOUT.replace("plant", "chair"), r"mine\.yaml:5: .*kind 'chair' is there already"),
        (LAYOUT.replace("plant", "unicorn"), "'unicorn' is no kind that instructions know, such as chair"),
        (LAYOUT.replace("plant", "sofa"), "it is called 'couch'"),
        (LAYOUT + "boxes: middle\n", r"mine\.yaml:6: boxes"),
        (LAYOUT + "input: {colour: rgb}\n", r"mine\.yaml:6: .*colors"),
        (LAYOUT + "input: {mean: [0.5]}\n", "expected three numbers, one of each channel, got 1"),
        (LAYOUT + "confidence: 2\n", r"mine\.yaml:6: confidence"),
        (LAYOUT + '  - "-"\n', r"its first output must be \(1, N, 8\) or .* got \(1, 5, 7\)"),
    ],
)
def test_a_wrong_layout_is_one_error(mine: Path, layout: str | None, says: str) -> None:
    if layout is None:
        mine.with_suffix(".yaml").unlink()
    else:
        mine.with_suffix(".yaml").write_text(layout)
    with pytest.raises(ConfigError, match=says):
        Robot(detector=mine)


def test_a_wrong_graph_is_one_error(mine: Path, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="no such file"):
        Robot(detector=tmp_path / "none.onnx")
    with pytest.raises(ConfigError, match="there is no detector 'outdoor'"):
        Robot(detector="outdoor")
    for shape, says in [
        ((1, 4, 120, 160), r"its input must be one picture"),
        ((1, 120), r"its input must be one picture"),
        ((1, 3, "h", "w"), "a fixed height and width of 16 to 4096 pixels"),
        ((1, 3, 8, 8), "a fixed height and width of 16 to 4096 pixels"),
    ]:
        graph(mine, shape=shape)
        with pytest.raises(ConfigError, match=says):
            Robot(detector=mine)
    graph(mine, type_=onnx.TensorProto.INT64)
    with pytest.raises(ConfigError, match="its input must be one picture"):
        Robot(detector=mine)
    mine.write_bytes(b"no graph")
    with pytest.raises(ConfigError, match="no ONNX graph"):
        Robot(detector=mine)


def test_a_network_that_gives_no_numbers_ends_the_instruction_with_one_error(mine: Path) -> None:
    graph(mine, np.array(BOXES) * np.nan)
    with sync.Robot(scene="corridor_v1", detector=mine) as robot:
        with pytest.raises(ConfigError, match="its output is not finite"):
            robot.execute_instruction("move forward 1 m")
        robot.sleep(1.0)
        assert abs(robot.get_velocity().vx) < 0.05
