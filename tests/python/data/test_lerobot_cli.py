"""The commands on LeRobot datasets, as a user types them."""

from __future__ import annotations

from pathlib import Path

import pytest
from data.lerobot_samples import SMALL, write
from threewe.data.cli import app
from threewe.data.lerobot import Dataset
from threewe.errors import ConfigError
from typer.testing import CliRunner


def run(*words: str | Path, status: int = 0) -> str:
    done = CliRunner().invoke(app, [str(word) for word in words], terminal_width=100)
    if isinstance(done.exception, ConfigError):
        raise done.exception
    assert done.exit_code == status, done.output
    return done.output


def test_info_shows_what_there_is(tmp_path: Path) -> None:
    write(tmp_path / "a", 1)
    said = run("info", tmp_path / "a")
    for word in ("LeRobot v3.0", "3, of 7 to 12 frames", "28 at 10 Hz", "go (2 episodes)", "48x64x3 h264", "v, omega"):
        assert word in said, said


def test_sound_and_faulty_datasets_are_told_apart(tmp_path: Path) -> None:
    write(tmp_path / "a", 2)
    assert "sound" in run("validate", tmp_path / "a")
    (tmp_path / "a/data/left.parquet").write_text("x")
    said = run("validate", tmp_path / "a", status=1)
    assert "data/left.parquet" in said
    assert "belongs to no episode" in said


def test_datasets_are_merged_converted_split_filtered_and_appended(tmp_path: Path) -> None:
    write(tmp_path / "a", 3)
    write(tmp_path / "b", 4)
    assert "6 episodes, 56 frames (6 s), v3.0" in run("merge", tmp_path / "a", tmp_path / "b", "-o", tmp_path / "c")
    assert "v2.1" in run("convert", tmp_path / "c", "-o", tmp_path / "old", "--version", "v2.1")
    said = run("split", tmp_path / "c", "train=0.5", "test=4,0-1", "-o", tmp_path / "parts")
    assert "3 episodes" in said
    assert [each.length for each in Dataset.open(tmp_path / "parts/test").episodes] == [12, 9, 12]
    words = ("--task", "go", "--success", "--episodes", "0-4")
    assert "3 episodes" in run("filter", tmp_path / "c", "-o", tmp_path / "d", *words)
    assert "6 episodes" in run("append", tmp_path / "a", tmp_path / "b")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("info", "{}/nobody"), "no folder of journals"),
        (("split", "{}/a", "train"), "a part is NAME=SHARE"),
        (("split", "{}/a", "train=many"), "neither a share nor"),
        (("filter", "{}/a", "-o", "{}/b", "--episodes", "1-x"), "is no episode"),
        (("merge", "{}/a", "-o", "{}/a"), "exists already"),
    ],
)
def test_what_cannot_be_done_is_said(tmp_path: Path, words: tuple[str, ...], message: str) -> None:
    write(tmp_path / "a", 5, features={name: SMALL[name] for name in ("action", "next.success")})
    with pytest.raises(ConfigError, match=message):
        run(*(word.format(tmp_path) for word in words))
