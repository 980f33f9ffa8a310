"""What is written as a LeRobot dataset is read back the same; wrong episodes and full disks spoil nothing."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from data.lerobot_samples import (
    CAMERA,
    CAMERAS,
    DEPTH,
    DEPTH_VIDEO,
    EVERYTHING,
    FPS,
    NUMBERS,
    SIZE,
    SMALL,
    STILL,
    add,
    episode,
    packets,
    write,
)
from threewe.data.lerobot import ArrayFrames, Dataset, DatasetWriter, FrameSource, PacketFrames, validate
from threewe.data.video import KeyFrameEncoder
from threewe.errors import ConfigError, ContractError

VERSIONS = ("v3.0", "v2.1")


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("codec", ["copy", "av1", "h264"])
def test_each_value_and_frame_comes_back(tmp_path: Path, version: Any, codec: Any) -> None:
    made = write(tmp_path / "made", 1, features=EVERYTHING, version=version, codec=codec)
    dataset = Dataset.open(tmp_path / "made")
    assert (dataset.version, dataset.fps, len(dataset), dataset.tasks) == (version, FPS, 3, ("go", "stop"))
    start = 0
    for number, (found, given) in enumerate(zip(dataset.episodes, made, strict=True)):
        columns = found.columns()
        for name, values in given.items():
            if name not in CAMERAS:
                np.testing.assert_array_equal(columns[name], values, err_msg=name)
        length = found.length
        np.testing.assert_array_equal(columns["timestamp"], (np.arange(length) / FPS).astype(np.float32))
        np.testing.assert_array_equal(columns["index"], np.arange(start, start + length))
        assert set(columns["episode_index"]) == {number}
        assert found.frame_tasks(columns) == [("go", "stop", "go")[number]] * length
        assert found.success() == (number != 1)
        np.testing.assert_array_equal(images(found.video(STILL)), given[STILL])
        np.testing.assert_array_equal(images(found.video(DEPTH)), given[DEPTH])
        assert np.abs(images(found.video(CAMERA)).astype(int) - given[CAMERA]).mean() < 25
        steps = np.abs(images(found.video(DEPTH_VIDEO)).astype(int) - given[DEPTH_VIDEO])
        assert steps.max() <= 2  # [mm] half a step of 12 bits on LeRobot's logarithmic scale up to 10 m
        start += length
    assert validate(tmp_path / "made") == []


def images(source: FrameSource) -> Any:
    return np.array([source.image(i) for i in range(len(source))])


def test_packets_are_copied_to_the_bit(tmp_path: Path) -> None:
    given = episode(np.random.default_rng(2), 8)
    source = packets(given[CAMERA])
    with DatasetWriter(tmp_path / "made", fps=FPS, features=SMALL) as writer:
        writer.add_episode({name: given[name] for name in NUMBERS}, "go", {CAMERA: source})
    read = Dataset.open(tmp_path / "made").episodes[0].video(CAMERA)
    np.testing.assert_array_equal(images(read), images(source))
    file = (tmp_path / "made/videos" / CAMERA / "chunk-000/file-000.mp4").read_bytes()
    for packet in source.packets:  # the picture itself, behind the parameter sets
        assert packet[-200:] in file


def test_frames_that_were_kept_raw_go_between_the_copied(tmp_path: Path) -> None:
    class Mixed(PacketFrames):
        def packet(self, i: int) -> Any:
            return None if i % 3 == 1 else self.packets[i]

    given = episode(np.random.default_rng(3), 10)
    source = Mixed(packets(given[CAMERA]).packets, (*SIZE, 3))
    with DatasetWriter(tmp_path / "made", fps=FPS, features=SMALL) as writer:
        writer.add_episode({name: given[name] for name in NUMBERS}, "go", {CAMERA: source})
    assert validate(tmp_path / "made") == []
    read = images(Dataset.open(tmp_path / "made").episodes[0].video(CAMERA))
    assert np.abs(read.astype(int) - images(source)).mean() < 8


@pytest.mark.parametrize("codec", ["copy", "av1", "h264"])
def test_red_stays_red(tmp_path: Path, codec: Any) -> None:
    red = np.zeros((6, *SIZE, 3), np.uint8)
    red[:] = (40, 45, 50)
    red[:, 8:40, 16:48] = (200, 20, 30)
    columns = {name: episode(np.random.default_rng(4), 6)[name] for name in NUMBERS}
    source: FrameSource = packets(red) if codec == "copy" else ArrayFrames(red)
    with DatasetWriter(tmp_path / "made", fps=FPS, features=SMALL, codec=codec) as writer:
        writer.add_episode(columns, "go", {CAMERA: source})
    image = Dataset.open(tmp_path / "made").episodes[0].video(CAMERA).image(3)
    np.testing.assert_allclose(image[16:32, 24:40].mean((0, 1)), (200, 20, 30), atol=0.05 * 255)


def test_files_are_begun_anew_at_their_limits(tmp_path: Path) -> None:
    limits = {"data_files_size_in_mb": 0.001, "video_files_size_in_mb": 0.008, "chunks_size": 2}
    lengths = (9, 12, 7, 9, 9, 9)
    write(tmp_path / "made", 5, lengths, ("go",) * 6, **limits)
    names = sorted(path.relative_to(tmp_path / "made").as_posix() for path in (tmp_path / "made").rglob("*.*"))
    assert "data/chunk-001/file-000.parquet" in names
    assert f"videos/{CAMERA}/chunk-000/file-001.mp4" in names
    assert [each.length for each in Dataset.open(tmp_path / "made").episodes] == list(lengths)
    assert validate(tmp_path / "made") == []


def test_an_episode_is_a_row_group(tmp_path: Path) -> None:
    write(tmp_path / "made", 6)
    table = pq.ParquetFile(tmp_path / "made/data/chunk-000/file-000.parquet")
    assert [table.metadata.row_group(i).num_rows for i in range(table.num_row_groups)] == [9, 12, 7]
    features = json.loads(table.schema_arrow.metadata[b"huggingface"])["info"]["features"]
    assert features["action"] == {"feature": {"dtype": "float32", "_type": "Value"}, "length": 2, "_type": "List"}


def test_a_frame_may_have_its_own_task(tmp_path: Path) -> None:
    given = {name: episode(np.random.default_rng(7), 4)[name] for name in NUMBERS}
    with DatasetWriter(tmp_path / "made", fps=FPS, features=NUMBERS) as writer:
        writer.add_episode(given, ["a", "a", "b", "a"])
    (found,) = Dataset.open(tmp_path / "made").episodes
    assert found.tasks == ["a", "b"]
    assert found.frame_tasks(found.columns()) == ["a", "a", "b", "a"]


WRONG: list[tuple[dict[str, Any], str]] = [
    ({"action": None}, "columns: action missing"),
    ({"unknown": np.zeros(5)}, "columns: unknown not among the features"),
    ({"action": np.zeros((4, 2), np.float32)}, "one length"),
    ({"action": np.zeros((5, 3), np.float32)}, r"action: shape \(5, 3\); the feature says \(5, 2\)"),
    ({"action": np.full((5, 2), np.nan)}, "action: frame 0 is not finite"),
    ({"action": np.array([["a", "b"]] * 5)}, "action: <U1 does not fit into float32"),
    ({"next.success": np.zeros(5)}, "next.success: float64 does not fit into bool"),
]


@pytest.mark.parametrize(("change", "message"), WRONG)
def test_a_wrong_episode_is_refused_and_spoils_nothing(tmp_path: Path, change: dict[str, Any], message: str) -> None:
    rng = np.random.default_rng(8)
    with DatasetWriter(tmp_path / "made", fps=FPS, features=NUMBERS) as writer:
        sound = {name: episode(rng, 5)[name] for name in NUMBERS}
        writer.add_episode(sound, "go")
        wrong = {name: values for name, values in {**sound, **change}.items() if values is not None}
        with pytest.raises(ContractError, match=message):
            writer.add_episode(wrong, "go")
        writer.add_episode(sound, "go")
    assert len(Dataset.open(tmp_path / "made")) == 2
    assert validate(tmp_path / "made") == []


def test_frames_of_another_shape_and_no_packets_are_refused(tmp_path: Path) -> None:
    rng = np.random.default_rng(9)
    given = episode(rng, 5)
    columns = {name: given[name] for name in NUMBERS}
    with DatasetWriter(tmp_path / "made", fps=FPS, features=SMALL) as writer:
        add(writer, given)
        with pytest.raises(ContractError, match="frames have shape"):
            writer.add_episode(columns, "go", {CAMERA: ArrayFrames(given[CAMERA][:, :-8])})
        with pytest.raises((ContractError, ConfigError), match=r"H\.264"):
            writer.add_episode(columns, "go", {CAMERA: PacketFrames([b"no packet"] * 5, (*SIZE, 3))})
        smaller = PacketFrames(packets(given[CAMERA][:, :-8]).packets, (*SIZE, 3))
        with pytest.raises((ContractError, ConfigError), match=r"64x40|64x48"):
            writer.add_episode(columns, "go", {CAMERA: smaller})
        with pytest.raises(ContractError, match=r"videos: observation\.images\.front missing"):
            writer.add_episode(columns, "go")
        add(writer, given)
    assert validate(tmp_path / "made") == []


BAD_OPTIONS: list[tuple[dict[str, Any], str]] = [
    ({"fps": 0}, "fps must be"),
    ({"fps": 12.5}, "fps must be"),
    ({"version": "v2.0"}, "version 'v2.0': known are v3.0, v2.1"),
    ({"codec": "vp8"}, "codec 'vp8'"),
    ({"features": {"a/b": NUMBERS["action"]}}, "no name of a feature"),
    ({"features": {"timestamp": NUMBERS["action"]}}, "filled in by the writer"),
    ({"features": {"a": {"dtype": "complex64", "shape": [1]}}}, "dtype 'complex64' is not read"),
    ({"features": {"a": {"dtype": "video", "shape": [48, 64]}}}, "a camera has shape"),
]


@pytest.mark.parametrize(("change", "message"), BAD_OPTIONS)
def test_options_that_no_dataset_has_are_refused(tmp_path: Path, change: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        DatasetWriter(tmp_path / "made", **{"fps": FPS, "features": NUMBERS, **change})
    assert list(tmp_path.iterdir()) == []


def test_a_dataset_that_exists_is_not_overwritten(tmp_path: Path) -> None:
    write(tmp_path / "made", 10)
    before = (tmp_path / "made/meta/info.json").read_bytes()
    with pytest.raises(ConfigError, match="exists already"):
        DatasetWriter(tmp_path / "made", fps=FPS, features=NUMBERS)
    assert (tmp_path / "made/meta/info.json").read_bytes() == before


def test_an_error_in_the_block_leaves_nothing(tmp_path: Path) -> None:
    def fail(writer: DatasetWriter) -> None:
        add(writer, episode(np.random.default_rng(11), 5))
        raise KeyError("the caller's")

    with pytest.raises(KeyError), DatasetWriter(tmp_path / "made", fps=FPS, features=SMALL) as writer:
        fail(writer)
    assert list(tmp_path.iterdir()) == []


def test_a_killed_writer_leaves_nothing_that_looks_like_a_dataset(tmp_path: Path) -> None:
    program = """
import os, signal, sys
sys.path.insert(0, sys.argv[2])
import numpy as np
from pathlib import Path
from threewe.data.lerobot import DatasetWriter
from lerobot_samples import FPS, SMALL, add, episode
writer = DatasetWriter(Path(sys.argv[1]), fps=FPS, features=SMALL)
add(writer, episode(np.random.default_rng(0), 5))
os.kill(os.getpid(), signal.SIGKILL)
"""
    words = [sys.executable, "-c", program, str(tmp_path / "made"), str(Path(__file__).parent)]
    assert subprocess.run(words).returncode == -signal.SIGKILL
    assert not (tmp_path / "made").exists()
    (left,) = tmp_path.iterdir()
    with pytest.raises(ConfigError):
        Dataset.open(left)
    write(tmp_path / "made", 12)  # it is in no one's way
    assert validate(tmp_path / "made") == []


def test_a_full_disk_gives_up_the_dataset_with_an_error(tmp_path: Path) -> None:
    program = """
import resource, signal, sys
sys.path.insert(0, sys.argv[2])
import numpy as np
from pathlib import Path
from threewe.data.lerobot import DatasetWriter
from lerobot_samples import FPS, SMALL, add, episode
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (30_000, 30_000))  # no file may be larger, as on a disk that is full
rng = np.random.default_rng(0)
try:
    with DatasetWriter(Path(sys.argv[1]), fps=FPS, features=SMALL) as writer:
        for _ in range(20):
            add(writer, episode(rng, 12))
except Exception as error:
    print(type(error).__name__, isinstance(error, (OSError, ValueError)), error)
"""
    words = [sys.executable, "-c", program, str(tmp_path / "made"), str(Path(__file__).parent)]
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "True" in done.stdout, done.stdout
    assert list(tmp_path.iterdir()) == []


def test_encoders_say_nothing_on_the_terminal(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    write(tmp_path / "made", 13, features=EVERYTHING, codec="av1")
    assert capfd.readouterr() == ("", "")


def test_neither_lerobot_nor_pandas_is_imported() -> None:
    program = (
        "import threewe.data.lerobot, sys; print({'av', 'pyarrow', 'pandas', 'lerobot', 'torch'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, env={**os.environ})
    assert done.stdout.strip() == "set()", done.stderr


def test_a_recorders_frame_decodes_alone() -> None:
    rng = np.random.default_rng(14)
    given = episode(rng, 4)[CAMERA]
    encoder = KeyFrameEncoder((*SIZE, 3), "rgb24")
    units = [encoder.encode(image) for image in given]
    assert all(unit.startswith(b"\0\0\0\1") and b"\0\0\1\x68" in unit for unit in units)
    source = PacketFrames(units, (*SIZE, 3))
    np.testing.assert_array_equal(source.image(2), PacketFrames(units[2:3], (*SIZE, 3)).image(0))
