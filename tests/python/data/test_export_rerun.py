"""Rerun exports, judged by Rerun's own command and read back by its library."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest
from data.recorded import Recorded, record
from numpy.typing import NDArray
from rerun.chunk import RrdReader
from threewe import ConfigError
from threewe.data.exporting import export

RERUN = Path(sys.executable).parent / "rerun"


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Recorded:
    return record(tmp_path_factory.mktemp("rerun") / "video")


@pytest.fixture(scope="module")
def file(recorded: Recorded) -> Path:
    return export(recorded.recording, recorded.folder.parent / "rrd", "rerun") / "episode_000000.rrd"


def rows(file: Path, entity: str, component: str) -> list[tuple[int, Any]]:
    """(robot time [ns], value) in order of time."""
    found = []
    for chunk in RrdReader(file).stream().to_chunks():
        batch = chunk.to_record_batch()
        if chunk.entity_path == f"/{entity}" and not chunk.is_static and component in batch.schema.names:
            times = batch.column("robot_time").cast("int64").to_pylist()
            found += zip(times, batch.column(component).to_pylist(), strict=True)
    return sorted(((time, value) for time, value in found if value is not None), key=lambda row: row[0])


def nanoseconds(times: NDArray[np.float64]) -> list[int]:
    return [round(time * 1e9) for time in times]


def test_rerun_finds_every_file_sound(file: Path) -> None:
    assert sorted(path.name for path in file.parent.iterdir()) == ["episode_000000.rrd", "episode_000001.rrd"]
    for path in file.parent.iterdir():
        done = subprocess.run([RERUN, "rrd", "verify", path], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        assert "without error" in done.stdout + done.stderr


def test_poses_and_actions_are_those_of_every_tick(recorded: Recorded, file: Path) -> None:
    episode = recorded.recording[0]
    assert episode.true_pose is not None
    for entity, poses in (("map/estimated_robot", episode.pose), ("scene/true_robot", episode.true_pose)):
        found = rows(file, entity, "Transform3D:translation")
        np.testing.assert_allclose([time for time, _ in found], nanoseconds(episode.time), atol=1)
        np.testing.assert_allclose([value[0][:2] for _, value in found], poses[:, :2], atol=1e-5)
    for name, wanted in (("requested", episode.requested), ("executed", episode.executed)):
        found = rows(file, f"signals/velocity/{name}", "Scalars:scalars")
        np.testing.assert_allclose([value for _, value in found], wanted)


def test_lidar_points_lie_on_the_walls_of_the_room(recorded: Recorded, file: Path) -> None:
    """The room is 4 x 3 m and the robot starts 0.6 m from its western wall, in the middle."""
    found = rows(file, "map/lidar", "Points3D:positions")
    assert len(found) == len(recorded.recording[0].lidar())
    points = np.array(found[0][1])[:, :2]
    off = np.min([np.abs(points[:, 0] + 0.6), np.abs(points[:, 0] - 3.4), np.abs(np.abs(points[:, 1]) - 1.5)], axis=0)
    assert np.median(off) < 0.1  # the wall's half thickness, and noise; the couch stands before one of them


def test_the_stored_image_is_the_recorded_packet_and_red(recorded: Recorded, file: Path) -> None:
    camera = recorded.recording[0].camera()
    found = rows(file, "map/camera/color", "VideoStream:sample")
    packets = [np.asarray(value[0], np.uint8).tobytes() for _, value in found]
    assert packets == [camera.packet(i) for i in range(len(camera))]
    decoder = av.CodecContext.create("h264", "r")
    frames = [*decoder.decode(av.Packet(packets[0])), *decoder.decode(None)]
    recorded.assert_red(frames[0].to_ndarray(format="rgb24"))
    depth = rows(file, "map/camera/depth", "DepthImage:buffer")
    for i, (_, value) in enumerate(depth):
        pixels = np.asarray(value[0], np.uint8).view(np.uint16).reshape(camera.height, camera.width)
        np.testing.assert_array_equal(pixels, camera.depth(i))


def test_images_that_were_kept_raw_are_red(tmp_path: Path) -> None:
    raw = record(tmp_path / "raw", episodes=1, video=False)
    file = export(raw.recording, tmp_path / "one.rrd", "rerun")
    _, value = rows(file, "map/camera/color", "EncodedImage:blob")[0]
    with av.open(str(write(tmp_path / "image.jpg", value[0]))) as image:
        raw.assert_red(next(image.decode(video=0)).to_ndarray(format="rgb24"))


def write(path: Path, data: list[int]) -> Path:
    path.write_bytes(np.asarray(data, np.uint8).tobytes())
    return path


def test_mistakes_are_one_error(recorded: Recorded, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ConfigError, match="3we_depth_v2"):
        export(recorded.recording, tmp_path / "a", "rerun", hardware="3we_dept_v2")
    assert not list(tmp_path.iterdir())
    monkeypatch.setitem(sys.modules, "rerun", None)
    monkeypatch.delitem(sys.modules, "threewe.data.export_rerun")
    with pytest.raises(ConfigError, match=r'pip install "threewe\[viz\]"'):
        export(recorded.recording, tmp_path / "a", "rerun")
