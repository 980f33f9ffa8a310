"""Scenes, objects and robots of other people, found through THREEWE_PATH."""

from __future__ import annotations

import asyncio
import shutil
from pathlib import Path

import pytest
import threewe

LAMP = "category: lamp\nshapes:\n  floor:\n    - {cylinder: 0.15, z: [0, 1.6], material: metal}\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    for kind in ("scenes", "objects", "robots"):
        (tmp_path / kind).mkdir()
    monkeypatch.setenv("THREEWE_PATH", str(tmp_path))
    return tmp_path


def installed(kind: str, name: str) -> Path:
    return Path(threewe.asset_directories()[0]) / kind / f"{name}.yaml"


def test_a_scene_with_an_object_of_ones_own(folder: Path) -> None:
    text = threewe.Scene.generate(3).to_yaml(name="my_home")
    (folder / "objects/lamp.yaml").write_text(LAMP)
    (folder / "scenes/my_home.yaml").write_text(
        text.replace("objects:\n", "objects:\n  - {category: lamp, shape: floor, pose: [1.0, 0.0]}\n")
    )
    assert "my_home" in threewe.scene_names()
    assert threewe.Scene.load("my_home").objects[0].name == "lamp_1"


async def drive_a_metre(hardware: str) -> float:
    async with threewe.Robot(hardware=hardware, noise="ideal") as robot:
        await robot.move_forward(1.0)
        return float(robot.get_pose().x)


def test_a_robot_of_ones_own(folder: Path) -> None:
    shutil.copy(installed("robots", "3we_standard_v2"), folder / "robots/my_robot.yaml")
    assert "my_robot" in threewe.profile_names()
    assert asyncio.run(drive_a_metre("my_robot")) == pytest.approx(1.0, abs=0.1)


def test_a_name_that_two_folders_have_is_an_error_that_names_both(folder: Path) -> None:
    mine = folder / "scenes/office_v2.yaml"
    shutil.copy(installed("scenes", "office_v2"), mine)
    with pytest.raises(threewe.ConfigError, match="there are two scenes named 'office_v2'") as error:
        threewe.Scene.load("office_v2")
    assert str(mine) in str(error.value)
    assert str(installed("scenes", "office_v2")) in str(error.value)


def test_a_path_that_is_no_folder_is_an_error(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("THREEWE_PATH", f"{folder}:{folder / 'nothing'}")
    with pytest.raises(threewe.ConfigError, match="nothing' is not a folder"):
        threewe.scene_names()
