"""The command `threewe`, as someone who types it sees it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
import threewe
from PIL import Image


def run(*arguments: str, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", "from threewe.cli import main; main()", *arguments]
    return subprocess.run(command, capture_output=True, text=True, cwd=cwd, timeout=600)


def test_version() -> None:
    assert run("version").stdout.strip() == threewe.__version__


def test_help_names_every_command() -> None:
    text = run("--help").stdout
    for command in ("demo", "scenes", "doctor", "version"):
        assert command in text


def test_scenes_are_listed_with_their_sizes() -> None:
    text = run("scenes", "list").stdout
    for name in threewe.scene_names():
        assert name in text
    assert "20 x 15 m" in text


@pytest.mark.parametrize("name", threewe.scene_names())
def test_a_scene_is_drawn(name: str, tmp_path: Path) -> None:
    done = run("scenes", "show", name, "--width", "400", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    with Image.open(tmp_path / f"{name}.png") as picture:
        assert picture.width == 400
        assert len(picture.convert("RGB").getcolors(1 << 20) or []) > 20
    for room in threewe.Scene.load(name).rooms:
        assert room.name in done.stdout


def test_a_scene_is_generated_saved_and_drawn(tmp_path: Path) -> None:
    done = run("scenes", "generate", "--seed", "7", "--size", "12", "9", "-o", "home.yaml", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    saved = threewe.Scene.load(str(tmp_path / "home.yaml"))
    assert saved.to_yaml() == threewe.Scene.generate(7, size=(12.0, 9.0)).to_yaml(name="home")
    assert run("scenes", "show", "home.yaml", "--width", "200", cwd=tmp_path).returncode == 0
    assert (tmp_path / "home.png").exists()


def test_what_cannot_be_generated_is_one_line(tmp_path: Path) -> None:
    done = run("scenes", "generate", "--seed", "7", "--difficulty", "2", cwd=tmp_path)
    assert done.returncode == 2
    assert "difficulty 2 is outside [0, 1]" in done.stderr
    assert not list(tmp_path.iterdir())


def test_a_mistyped_scene_is_one_line_with_the_right_name(tmp_path: Path) -> None:
    done = run("scenes", "show", "ofice_v2", cwd=tmp_path)
    assert done.returncode == 2
    assert "did you mean 'office_v2'?" in done.stderr
    assert "Traceback" not in done.stderr
    assert not list(tmp_path.iterdir())


def test_a_picture_that_cannot_be_written_is_one_line(tmp_path: Path) -> None:
    done = run("scenes", "show", "office_v2", "-o", str(tmp_path / "missing" / "x.png"))
    assert done.returncode == 2
    assert "missing/x.png" in done.stderr.replace("\n", "")
    assert "Traceback" not in done.stderr


def test_a_mistyped_room_of_the_demo_costs_no_drive(tmp_path: Path) -> None:
    done = run("demo", "--place", "kitchn", "-o", str(tmp_path / "demo"))
    assert done.returncode == 2
    assert "did you mean 'kitchen'?" in done.stderr.replace("\n", " ")


def test_doctor_finds_a_working_installation() -> None:
    done = run("doctor")
    assert done.returncode == 0, done.stdout
    assert "simulated drive" in done.stdout
    assert "backend mock" in done.stdout
    assert "broken" not in done.stdout
