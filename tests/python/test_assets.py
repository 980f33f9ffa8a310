"""Scenes, objects and robots of other people, found through THREEWE_PATH: those of docs/how-to-scenes.md."""

from __future__ import annotations

from pathlib import Path

import command_line
import pytest
import threewe
from test_snippets import write_files


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    write_files("docs/how-to-scenes.md", tmp_path)
    monkeypatch.setenv("THREEWE_PATH", str(tmp_path / "my_assets"))
    return tmp_path / "my_assets"


@pytest.fixture(autouse=True)
def narrow_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    """It must not hide where a mistake is."""
    monkeypatch.setenv("COLUMNS", "80")


def column(text: str, index: int) -> str:
    """What a table says in a column, without its line breaks."""
    rows = [line.split("│") for line in text.splitlines()]
    return "".join(row[index].strip() for row in rows if len(row) > index)


def spoil(file: Path, right: str, wrong: str) -> str:
    """Writes a mistake into a file; its place, as an error should name it."""
    lines = file.read_text().splitlines()
    (line,) = (number for number, text in enumerate(lines, 1) if right in text)
    file.write_text("\n".join(lines).replace(right, wrong) + "\n")
    return f"{file}:{line}: "


@pytest.mark.usefixtures("folder")
async def test_a_robot_of_ones_own_drives_through_a_scene_of_ones_own() -> None:
    async with threewe.Robot(scene="my_place", hardware="my_robot") as robot:
        assert robot.profile.kinematics == threewe.Kinematics.differential
        result = await robot.move_to(5.5, 0.5)  # in the den
        assert result.success, result
        assert robot.simulation is not None
        x, y, _ = robot.simulation.true_pose()
    assert (x, y) == pytest.approx((5.5, 0.5), abs=0.35)


@pytest.mark.usefixtures("folder")
def test_they_stand_beside_those_that_come_with_3we() -> None:
    assert {"my_place", "office_v2"} <= set(threewe.scene_names())
    assert {"my_robot", "3we_standard_v2"} <= set(threewe.profile_names())
    names = [thing.name for thing in threewe.Scene.load("my_place").objects]
    assert names == ["reading_lamp", "chair_1", "desk_1", "lamp_2"]


def test_a_path_needs_no_folder(folder: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("THREEWE_PATH")
    alone = (folder / "robots/my_robot.yaml").rename(tmp_path / "my_robot.yaml")
    threewe.Robot(scene="corridor_v1", hardware=str(alone))


@pytest.mark.usefixtures("folder")
def test_the_command_lists_and_draws_them(tmp_path: Path) -> None:
    assert "my_place" in column(command_line.threewe("scenes", "list").stdout, 1)
    done = command_line.threewe("scenes", "show", "my_place", "-o", str(tmp_path / "place.png"))
    assert "den" in done.stdout
    assert (tmp_path / "place.png").exists()


def test_one_broken_scene_does_not_hide_the_others(folder: Path) -> None:
    place = spoil(folder / "scenes/my_place.yaml", "floor: carpet", "floor: carpt")
    done = command_line.threewe("scenes", "list")
    assert done.returncode == 1
    assert "office_v2" in done.stdout
    assert "warehouse_v1" in done.stdout
    assert place.strip() in column(done.stdout, 5)


def test_the_doctor_names_what_is_broken(folder: Path) -> None:
    place = spoil(folder / "robots/my_robot.yaml", "mass: 3.0", "mass: 3000")
    done = command_line.threewe("doctor")
    assert done.returncode == 1
    assert place.strip() in column(done.stdout, 2)


@pytest.mark.parametrize(
    ("file", "right", "wrong", "message"),
    [
        ("scenes/my_place.yaml", "floor: carpet", "floor: carpt", "did you mean 'carpet'"),
        ("scenes/my_place.yaml", "category: chair", "category: chiar", "did you mean 'chair'"),
        ("scenes/my_place.yaml", "shape: floor", "shape: flor", "did you mean 'floor'"),
        ("scenes/my_place.yaml", "name: my_place", "name: your_place", "expected 'my_place', the name of the file"),
        ("scenes/my_place.yaml", "pose: [4, 3.2, -1.5708]", "pose: [3, 3.2, 0]", "overlaps 'reading_lamp'"),
        ("objects/lamp.yaml", "cylinder: 0.14", "cylinder: 14", r"14 is outside \[0.0025, 10\]"),
        ("objects/lamp.yaml", "{cylinder: 0.2,", "{clyinder: 0.2,", "expected either 'box' or 'cylinder'"),
        ("objects/lamp.yaml", "category: lamp", "category: light", "expected 'lamp', the name of the file"),
        ("robots/my_robot.yaml", "mass: 3.0", "mas: 3.0", "'mass'.*'mas'"),
        ("robots/my_robot.yaml", "kinematics: differential", "kinematics: diferential", "did you mean 'differential'"),
        ("robots/my_robot.yaml", "beams: 360", "beams: 3600", "3600 beams cannot be made of 400 points a turn"),
    ],
)
def test_a_mistake_is_named_with_file_and_line(folder: Path, file: str, right: str, wrong: str, message: str) -> None:
    place = spoil(folder / file, right, wrong)
    with pytest.raises(threewe.ConfigError, match=message) as error:
        threewe.Robot(scene="my_place", hardware="my_robot")
    assert place in str(error.value)


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(
    ("mistyped", "right"), [({"scene": "my_plaice"}, "my_place"), ({"hardware": "my_robt"}, "my_robot")]
)
def test_an_unknown_name_is_answered_with_the_nearest(mistyped: dict[str, str], right: str) -> None:
    with pytest.raises(threewe.ConfigError, match=f"did you mean '{right}'"):
        threewe.Robot(**mistyped)


@pytest.mark.parametrize(
    ("mine", "ours"),
    [
        ("scenes/my_place.yaml", "scenes/office_v2.yaml"),
        ("objects/lamp.yaml", "objects/chair.yaml"),
        ("robots/my_robot.yaml", "robots/3we_standard_v2.yaml"),
    ],
)
def test_a_name_that_two_folders_have_is_an_error_that_names_both(folder: Path, mine: str, ours: str) -> None:
    (folder / mine).rename(folder / ours)
    with pytest.raises(threewe.ConfigError, match=f"there are two .* named '{Path(ours).stem}'") as error:
        threewe.Robot()
    for directory in (folder, Path(threewe.asset_directories()[0])):
        assert str(directory / ours) in str(error.value)


def test_a_path_that_is_no_folder_is_an_error(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("THREEWE_PATH", f"{folder}:{folder / 'nothing'}")
    with pytest.raises(threewe.ConfigError, match="nothing' is not a folder"):
        threewe.scene_names()
