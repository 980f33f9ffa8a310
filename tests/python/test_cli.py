"""The command `threewe`, as someone who types it sees it."""

from __future__ import annotations

import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import command_line
import numpy as np
import pytest
import threewe
from PIL import Image
from threewe import OccupancyGrid, cli
from threewe.doctor import Finding
from threewe.slam import load_map, save_map


def run(*arguments: str, cwd: Path | None = None, without: str = "") -> subprocess.CompletedProcess[str]:
    """In a process of its own, where a module may be missing."""
    absent = f"import sys; sys.modules['{without}'] = None; " if without else ""
    command = [sys.executable, "-c", f"{absent}from threewe.cli import main; main()", *arguments]
    return subprocess.run(command, capture_output=True, text=True, cwd=cwd, timeout=600)


def test_version() -> None:
    assert run("version").stdout.strip() == threewe.__version__


def test_a_program_ends_as_the_command_does_in_this_process() -> None:
    for arguments in (["hardware", "list"], ["drive", "--to", "nan", "1"], ["drive", "--to", "1"]):
        program, here = run(*arguments), command_line.threewe(*arguments)
        assert (program.returncode, program.stdout) == (here.returncode, here.stdout)
        assert program.stderr == here.stderr.replace("threewe ", "-c ")


def test_help_names_every_command() -> None:
    text = command_line.threewe("--help").stdout
    for command in ("demo", "drive", "explore", "teleop", "view", "export", "scenes", "hardware", "doctor", "version"):
        assert command in text


def test_robots_are_listed_and_shown() -> None:
    text = command_line.threewe("hardware", "list").stdout
    for name in threewe.profile_names():
        assert name in text
    shown = command_line.threewe("hardware", "show", "turtlebot_like").stdout
    assert "differential" in shown
    assert "0.22 m/s" in shown
    assert "lidar, imu, odometry" in shown


def test_parameters_are_shown_with_where_they_come_from(tmp_path: Path) -> None:
    own = tmp_path / "mine.yaml"
    own.write_text(threewe.RobotProfile.load("turtlebot_like").yaml + "\nautonomy:\n  nav: {recovery: {attempts: 4}}\n")
    done = command_line.threewe("hardware", "show", str(own), "--parameters", "--only", "nav.recovery", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    parameters = {one.name: one for one in threewe.RobotProfile.load(str(own)).parameters()}
    attempts = parameters["nav.recovery.attempts"]
    assert (attempts.value, attempts.reference, attempts.is_count) == (4.0, 8.0, True)
    assert "mine.yaml:" in attempts.origin
    look = parameters["nav.recovery.look"]
    assert (look.unit, look.scale, look.origin) == ("rad", "none", "default")
    assert parameters["safety.gate.margin"].origin.startswith("size x 0.686")
    assert parameters["slam.map_resolution"].value == 0.05  # as its map has it: a power of two of that
    for word in ("nav.recovery.attempts", "rad", "default"):
        assert word in done.stdout


def test_the_reference_robot_has_every_default() -> None:
    for one in threewe.RobotProfile.load("3we_standard_v2").parameters():
        assert one.origin == "default", one
        assert one.value == one.reference, one
        assert one.meaning, one


def test_a_wrong_parameter_is_one_error_with_its_place(tmp_path: Path) -> None:
    own = tmp_path / "mine.yaml"
    own.write_text(threewe.RobotProfile.load("3we_standard_v2").yaml + "\nautonomy:\n  nav: {recovery: {atempts: 4}}\n")
    with pytest.raises(threewe.ConfigError, match=r"mine.yaml:\d+: .*did you mean 'recovery.attempts'\?"):
        threewe.Robot(hardware=str(own))


def test_scenes_are_listed_with_their_sizes() -> None:
    text = command_line.threewe("scenes", "list").stdout
    for name in threewe.scene_names():
        assert name in text
    assert "20 x 15 m" in text


@pytest.mark.parametrize("name", threewe.scene_names())
def test_a_scene_is_drawn(name: str, tmp_path: Path) -> None:
    done = command_line.threewe("scenes", "show", name, "--width", "400", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    with Image.open(tmp_path / f"{name}.png") as picture:
        assert picture.width == 400
        assert len(picture.convert("RGB").getcolors(1 << 20) or []) > 20
    for room in threewe.Scene.load(name).rooms:
        assert room.name in done.stdout


def test_a_scene_is_generated_saved_and_drawn(tmp_path: Path) -> None:
    done = command_line.threewe(
        "scenes", "generate", "--seed", "7", "--size", "12", "9", "-o", "home.yaml", cwd=tmp_path
    )
    assert done.returncode == 0, done.stderr
    saved = threewe.Scene.load(str(tmp_path / "home.yaml"))
    assert saved.to_yaml() == threewe.Scene.generate(7, size=(12.0, 9.0)).to_yaml(name="home")
    assert command_line.threewe("scenes", "show", "home.yaml", "--width", "200", cwd=tmp_path).returncode == 0
    assert (tmp_path / "home.png").exists()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--seed", "7", "--difficulty", "2"], "difficulty 2 is outside [0, 1]"),
        (["--seed", "7", "--difficulty", "nan"], "difficulty nan is outside [0, 1]"),
        (["--seed", "7", "--size", "1e9", "10"], "a side of 1000000000 m is outside [6, 40]"),
        (["--seed", str(2**64)], "Invalid value for '--seed'"),
        (["--seed", "-1"], "Invalid value for '--seed'"),
    ],
)
def test_what_cannot_be_generated_is_told_without_a_traceback(
    arguments: list[str], message: str, tmp_path: Path
) -> None:
    done = command_line.threewe("scenes", "generate", *arguments, cwd=tmp_path)
    assert done.returncode == 2
    assert message in done.stderr
    assert "Traceback" not in done.stderr
    assert not list(tmp_path.iterdir())


def test_a_mistyped_scene_is_one_line_with_the_right_name(tmp_path: Path) -> None:
    done = command_line.threewe("scenes", "show", "ofice_v2", cwd=tmp_path)
    assert done.returncode == 2
    assert "did you mean 'office_v2'?" in done.stderr
    assert "Traceback" not in done.stderr
    assert not list(tmp_path.iterdir())


def test_a_picture_that_cannot_be_written_is_one_line(tmp_path: Path) -> None:
    done = command_line.threewe("scenes", "show", "office_v2", "-o", str(tmp_path / "missing" / "x.png"))
    assert done.returncode == 2
    assert "missing/x.png" in done.stderr.replace("\n", "")
    assert "Traceback" not in done.stderr


def test_a_picture_needs_the_name_of_a_picture(tmp_path: Path) -> None:
    for output in (tmp_path / "office.foo", tmp_path):
        done = command_line.threewe("scenes", "show", "office_v2", "-o", str(output))
        assert done.returncode == 2
        assert "a picture ends in .png or .jpg" in done.stderr.replace("\n", " ")
        assert "Traceback" not in done.stderr
    assert not list(tmp_path.iterdir())


def test_a_mistyped_room_of_the_demo_costs_no_drive(tmp_path: Path) -> None:
    done = command_line.threewe("demo", "--place", "kitchn", "-o", str(tmp_path / "demo"))
    assert done.returncode == 2
    assert "did you mean 'kitchen'?" in done.stderr.replace("\n", " ")


def test_a_drive_and_an_exploration_say_how_they_ended() -> None:
    done = command_line.threewe("drive", "--to", "2", "1", "--heading", "90")
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("reached: ")
    done = command_line.threewe("explore", "--scene", "corridor_v1", "--seconds", "5")
    assert done.returncode == 0, done.stderr
    assert "timeout, after 5.00 s: " in done.stdout


def test_a_drive_that_fails_says_why() -> None:
    done = command_line.threewe("drive", "--to", "2", "1", "--seconds", "1")
    assert done.returncode == 1
    assert done.stdout.startswith("timeout, after 1.00 s: ")


def test_a_map_is_saved_and_driven_in(tmp_path: Path) -> None:
    (tmp_path / "maps").mkdir()
    done = command_line.threewe("drive", "--to", "2", "1", "--seconds", "2", "--save-map", "maps/office", cwd=tmp_path)
    assert done.returncode == 1  # the map is kept however the drive ends
    assert "map saved to maps/office.yaml" in done.stdout
    assert {file.name for file in (tmp_path / "maps").iterdir()} == {"office.yaml", "office.pgm"}

    done = command_line.threewe(
        "drive", "--to", "1", "0.5", "--map", "maps/office.yaml", "--save-map", "maps/more.yaml", cwd=tmp_path
    )
    assert done.returncode == 0, done.stderr
    first, more = (load_map(tmp_path / "maps" / name) for name in ("office.yaml", "more.yaml"))
    assert np.count_nonzero(more.data >= 0) >= np.count_nonzero(first.data >= 0)

    done = command_line.threewe("explore", "--seconds", "2", "--map", "maps/office.yaml", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "timeout, after 2.00 s: " in done.stdout


def test_a_robot_in_a_map_of_another_place_says_that_it_is_lost(tmp_path: Path) -> None:
    save_map(OccupancyGrid(np.zeros((40, 40), np.int8)), tmp_path / "bare.yaml")
    done = command_line.threewe("explore", "--map", "bare.yaml", cwd=tmp_path)
    assert done.returncode == 1
    assert done.stdout.startswith("lost, no place in the map")


@pytest.mark.parametrize("command", [["drive", "--to", "1", "0"], ["explore"]])
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--map", "missing.yaml"], "missing.yaml"),
        (["--map", "not_a.yaml"], "not_a.yaml"),
        (["--map", "no_picture.yaml"], "no_picture.pgm"),
        (["--map", "map.pgm"], "map.pgm"),
        (["--save-map", "missing/office"], "there is no folder 'missing'"),
        (["--save-map", "office.png"], "ends in .yaml or in nothing, not '.png'"),
        (["--save-map", "folder"], "'folder.yaml' cannot be written"),
    ],
)
def test_maps_that_cannot_be_read_or_kept_cost_no_drive(
    command: list[str], arguments: list[str], message: str, tmp_path: Path
) -> None:
    (tmp_path / "not_a.yaml").write_text("image: [\n")
    (tmp_path / "no_picture.yaml").write_text(
        "image: no_picture.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.196\nnegate: 0\n"
    )
    (tmp_path / "map.pgm").write_text("P5 1 1 255 ")
    (tmp_path / "folder.yaml").mkdir()
    done = command_line.threewe(*command, *arguments, cwd=tmp_path)
    assert done.returncode == 2
    assert done.stdout == ""
    assert message in done.stderr.replace("\n", "")
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["drive", "--to", "nan", "1"], "goal x"),
        (["drive", "--to", "1"], "'--to' requires 2 arguments"),
        (["drive", "--to", "1", "1", "--scene", "ofice_v2"], "did you mean 'office_v2'?"),
        (["explore", "--hardware", "3we_base_v2"], "lidar"),
        (["drive", "--to", "1", "0", "--hardware", "3we_base_v2", "--save-map", "x"], "lidar"),
        (["explore", "--save", "a.rrd", "--serve"], "choose one"),
        (["explore", "--save", "a.txt"], "ends in .rrd"),
    ],
)
def test_what_cannot_be_driven_is_one_line(arguments: list[str], message: str) -> None:
    done = command_line.threewe(*arguments)
    assert done.returncode == 2
    assert message in done.stderr.replace("\n", "")
    assert "Traceback" not in done.stderr


def test_square_brackets_are_not_lost(tmp_path: Path) -> None:
    (tmp_path / "hall.yaml").write_text("name: hall\ndescription: a hall\nstarts:\n  - [1]\n")
    done = command_line.threewe("scenes", "show", "hall.yaml", cwd=tmp_path)
    assert done.returncode == 2
    assert "expected [x, y, theta]" in done.stderr


@pytest.mark.parametrize("arguments", [["demo"], ["scenes", "show", "office_v2"]])
def test_a_missing_extra_is_one_line_that_says_how_to_install_it(arguments: list[str], tmp_path: Path) -> None:
    done = run(*arguments, cwd=tmp_path, without="PIL")
    assert done.returncode == 2
    assert "-m pip install 'threewe[demo]'" in " ".join(done.stderr.split())
    assert "Traceback" not in done.stderr


def test_the_demo_does_not_drive_before_it_misses_its_film(tmp_path: Path) -> None:
    done = run("demo", cwd=tmp_path, without="av")
    assert done.returncode == 2
    assert "exploring" not in done.stdout
    assert not list(tmp_path.iterdir())


def test_doctor_says_which_extra_is_missing(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    finding = Finding("pillow", "missing", "needed for pictures", "python -m pip install 'threewe[demo]'")
    monkeypatch.setattr("threewe.doctor.examine", lambda: [finding])
    monkeypatch.setenv("COLUMNS", "200")
    cli.doctor()
    assert "pip install 'threewe[demo]'" in capsys.readouterr().out


def test_doctor_finds_a_working_installation() -> None:
    done = run("doctor")
    assert done.returncode == 0, done.stdout
    assert "simulated drive" in done.stdout
    assert "backend mock" in done.stdout
    assert "broken" not in done.stdout
    assert ("cameras on mujoco" in done.stdout) == (find_spec("mujoco") is not None)
