"""The object detector: what it says of pictures, and of files that are none."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from safetensors import safe_open
from safetensors.numpy import save_file
from threewe import ConfigError, ContractError, Robot, asset_directories, sync
from threewe._core import Detector

[SHIPPED] = [
    path for folder in asset_directories() if (path := Path(folder, "detectors/indoor_v1.safetensors")).exists()
]


def test_radii_are_those_of_the_kinds() -> None:
    detector = Detector.load()
    assert detector.labels[0] == "background"
    radii = dict(zip(detector.labels, detector.radii, strict=True))
    assert radii["background"] == 0.0
    assert radii["cup"] < radii["chair"] < radii["bed"]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"labels": "chair"}, "'labels' must be a list of names"),
        ({"labels": json.dumps(["background", "chair"]), "radii": "[0, 0.4]"}, "two more than its 2 labels"),
        ({"radii": None}, "radii"),
        ({"radii": "[0.1, null]"}, "'radii' must be a list of numbers"),
        ({"radii": "[0.1]"}, "'radii' must be a number of 0 to 20 m for each of the"),
        ({"radii": json.dumps([-1.0] * 18)}, "'radii' must be a number of 0 to 20 m for each of the"),
        ({"layers": "[]"}, "layers"),
    ],
)
def test_a_file_with_wrong_metadata_is_one_error(tmp_path: Path, changes: dict[str, str | None], message: str) -> None:
    file = safe_open(str(SHIPPED), "np")
    metadata = {**file.metadata(), **changes}
    path = tmp_path / "mine.safetensors"
    save_file(
        {name: file.get_tensor(name) for name in file.keys()},  # noqa: SIM118 (it is no dictionary)
        path,
        {name: text for name, text in metadata.items() if text is not None},
    )
    with pytest.raises(ConfigError, match=r"mine\.safetensors") as error:
        Detector.load(str(path))
    assert message in str(error.value)


@pytest.mark.parametrize("length", [0, 7, 100, 5000])
def test_a_file_that_ends_early_is_one_error(tmp_path: Path, length: int) -> None:
    path = tmp_path / "mine.safetensors"
    path.write_bytes(SHIPPED.read_bytes()[:length])
    with pytest.raises(ConfigError, match=r"mine\.safetensors"):
        Detector.load(str(path))


def test_an_unknown_detector_names_the_known_one() -> None:
    with pytest.raises(ConfigError, match="indoor_v1"):
        Detector.load("outdoor_v1")


def test_a_picture_of_another_size_is_refused() -> None:
    camera = Robot().profile.camera
    assert camera is not None
    with pytest.raises(ContractError, match="640 x 480"):
        Detector.load().detect(np.zeros((240, 320, 3), np.uint8), camera.intrinsics)


def test_the_floor_between_its_legs_is_not_the_color_of_a_chair() -> None:
    """Two brown chairs, of whose cells half are gray floor."""
    detector = Detector.load()
    chair = detector.labels.index("chair")
    for scene, pose in [("office_v2", (0.125, -4.875, -0.603)), ("apartment_v1", (-1.825, 4.125, 2.814))]:
        with sync.Robot(scene=scene, start_pose=pose, noise="ideal", localization="truth") as robot:
            found = detector.detect(robot.get_image(), robot.simulation.look().intrinsics)
        assert max((d for d in found if d.kind_index == chair), key=lambda d: d.confidence).color == "brown"


def test_what_stands_behind_a_column_is_one_thing(tmp_path: Path) -> None:
    scene = """name: room
description: A couch behind a column.
starts: [[1.0, 3.0, 0.0]]
rooms:
  - {name: room, min: [0.0, 0.0], max: [13.0, 6.0], floor: wood}
walls:
  - {a: [0, 0], b: [13, 0]}
  - {a: [13, 0], b: [13, 6]}
  - {a: [13, 6], b: [0, 6]}
  - {a: [0, 6], b: [0, 0]}
objects:
  - {name: couch_1, category: couch, shape: two_seat, pose: [4.0, 3.0, 3.14159]}
  - {name: column_1, category: column, shape: round, pose: [2.6, 3.0, 0.0]}
"""
    Path(tmp_path, "room.yaml").write_text(scene)
    detector = Detector.load()
    with sync.Robot(scene=str(tmp_path / "room.yaml"), noise="ideal", localization="truth") as robot:
        found = detector.detect(robot.get_image(), robot.simulation.look().intrinsics)
    column, couches = (
        [d.box for d in found if detector.labels[d.kind_index] == kind and d.confidence > 0.6]
        for kind in ("column", "couch")
    )
    [couch] = couches
    assert couch[0] < column[0][0]
    assert column[0][2] < couch[2]
