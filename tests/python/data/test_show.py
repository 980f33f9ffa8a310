"""Contact sheets: what is on them, by pixels that must be there, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from data.recorded import Recorded, record
from numpy.typing import NDArray
from PIL import Image
from threewe import ConfigError, ContractError
from threewe.data import contact_sheet as sheet
from threewe.data import showing
from threewe.data.cli import app
from threewe.data.exporting import export
from typer.testing import CliRunner


def run(*words: str | Path, status: int = 0) -> str:
    done = CliRunner().invoke(app, [str(word) for word in words], terminal_width=100)
    if isinstance(done.exception, ConfigError):
        raise done.exception
    assert done.exit_code == status, done.output
    return done.output


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Recorded:
    return record(tmp_path_factory.mktemp("show") / "video", episodes=3)


@pytest.fixture(scope="module")
def dataset(recorded: Recorded) -> Path:
    return export(recorded.recording, recorded.folder.parent / "dataset", fps=10)


def pixels(image: Image.Image) -> NDArray[np.uint8]:
    return np.asarray(image.convert("RGB"))


def frame(image: Image.Image, row: int, column: int) -> NDArray[np.uint8]:
    top = sheet.HEADER + row * (sheet.FRAME_HEIGHT + 2 * sheet.GAP) + sheet.GAP
    left = sheet.MARGIN + sheet.TEXT_WIDTH + column * (sheet.FRAME_WIDTH + sheet.GAP)
    return pixels(image)[top : top + sheet.FRAME_HEIGHT, left : left + sheet.FRAME_WIDTH]


def has(image: NDArray[np.uint8], color: tuple[int, ...]) -> bool:
    """At least a few pixels that are nearly so."""
    return int((np.abs(image.astype(int) - color[:3]).max(axis=-1) < 12).sum()) > 10


def text(image: Image.Image, row: int) -> NDArray[np.uint8]:
    top = sheet.HEADER + row * (sheet.FRAME_HEIGHT + 2 * sheet.GAP)
    return pixels(image)[top : top + sheet.FRAME_HEIGHT, : sheet.MARGIN + sheet.TEXT_WIDTH]


def test_a_row_shows_frames_path_and_success(recorded: Recorded) -> None:
    image = showing.contact_sheet(recorded.recording, frames=3)
    couch = np.asarray(Image.fromarray(recorded.couch).resize((sheet.FRAME_WIDTH, sheet.FRAME_HEIGHT)))
    found = frame(image, 0, 0)[couch][:, :].mean(axis=0)
    np.testing.assert_allclose(found, recorded.color, atol=0.05 * 255)  # red, in RGB
    assert has(frame(image, 0, 3), sheet.d.TRAJECTORY)
    assert has(frame(image, 0, 3), sheet.d.BODY)
    assert has(text(image, 0), sheet.SUCCEEDED)
    assert has(text(image, 1), sheet.FAILED)
    assert not has(text(image, 1), sheet.SUCCEEDED)


def test_a_dataset_looks_like_its_recording(recorded: Recorded, dataset: Path) -> None:
    ours, theirs = (showing.contact_sheet(source, frames=3) for source in (recorded.folder, dataset))
    assert ours.size == theirs.size
    for row in range(3):
        difference = frame(ours, row, 0).astype(int) - frame(theirs, row, 0)
        assert np.abs(difference).mean() < 6.0
        assert has(frame(theirs, row, 3), sheet.d.TRAJECTORY)


def test_episodes_can_be_chosen(recorded: Recorded, dataset: Path) -> None:
    for source in (recorded.folder, dataset):
        one = showing.contact_sheet(source, episodes=[1], frames=2)
        assert one.height < showing.contact_sheet(source, frames=2).height
        assert has(pixels(one), sheet.FAILED), source
        with pytest.raises(ConfigError, match="no episode 7; there are 3, numbered 0 to 2"):
            showing.contact_sheet(source, episodes=[1, 7])


def test_without_a_camera_the_scans_are_shown(recorded: Recorded, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("threewe.data.recording.RecordedEpisode.cameras", [])
    image = showing.contact_sheet(recorded.folder, frames=2)
    assert has(frame(image, 0, 0), sheet.d.HITS)


def test_without_a_scene_what_the_lidar_hit_is_drawn(recorded: Recorded, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("threewe.data.recording.RecordedEpisode.origin", None)
    image = showing.contact_sheet(recorded.folder, frames=1)
    assert has(frame(image, 0, 1), sheet.WALL)
    assert has(frame(image, 0, 1), sheet.d.TRAJECTORY)


def test_what_cannot_be_shown_is_one_error(recorded: Recorded, tmp_path: Path) -> None:
    (tmp_path / "there.png").write_text("mine")
    for output, message in (("a.jpg", "ends in .png"), ("there.png", "exists already")):
        with pytest.raises(ConfigError, match=message):
            showing.show(recorded.folder, tmp_path / output)
    with pytest.raises(ContractError, match=r"frames must lie in \[1, 20\]"):
        showing.contact_sheet(recorded.folder, frames=0)
    with pytest.raises(ConfigError, match="nobody"):
        showing.contact_sheet(tmp_path / "nobody")
    assert [path.name for path in tmp_path.iterdir()] == ["there.png"]


def test_rerun_needs_a_display_and_a_recording(
    recorded: Recorded, dataset: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    with pytest.raises(ConfigError, match="no display"):
        run("show", recorded.folder, "--rerun")
    with pytest.raises(ConfigError, match="Rerun shows recordings"):
        run("show", dataset, "--rerun")


def test_the_commands(recorded: Recorded, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert "journals.png" in run("show", recorded.folder, "--episodes", "0,2", "--frames", "2")
    with Image.open(tmp_path / "journals.png") as made:
        assert made.height > 2 * sheet.FRAME_HEIGHT
    for name, output in (("hdf5", "a.h5"), ("mcap", "mcap"), ("rerun", "rrd"), ("tum", "tum"), ("lerobot", "dataset")):
        assert f"{output}: 3 episodes as {name}" in run("export", recorded.folder, "-o", output, "-f", name)
    assert "3 episodes" in run("export", recorded.folder, "-o", "both", "-f", "tum", "--truth")
    assert len(list((tmp_path / "both").iterdir())) == 6
    with pytest.raises(ConfigError, match="format 'mcap': unknown option 'truth'; known: hardware"):
        run("export", recorded.folder, "-o", "b", "-f", "mcap", "--truth")
