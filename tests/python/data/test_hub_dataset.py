"""Datasets that are none, or that someone has tampered with, are refused before anything is sent."""

from __future__ import annotations

import contextlib
import io
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from data.tiny_dataset import CAMERA, HUES, write_tiny_dataset
from PIL import Image
from threewe import ConfigError
from threewe.data.hub_card import card, contact_sheet
from threewe.data.hub_dataset import open_whole
from threewe.data.lerobot import Dataset

EPISODES = "meta/episodes/chunk-000/file-000.parquet"


@pytest.fixture
def dataset(tmp_path: Path) -> Path:
    return write_tiny_dataset(tmp_path / "my_dataset")


def change(path: Path, **fields: Any) -> None:
    path.write_text(json.dumps(json.loads(path.read_text()) | fields))


def test_the_figures_are_those_of_the_files(dataset: Path) -> None:
    page = card(open_whole(dataset), "me/tiny", None, preview=False)
    assert r"| 3we\_standard\_v2 | 3 | 24 | 10 | 2 s |" in page
    assert "- go to the kitchen" in page
    assert "| `action` | float32 | 3 | vx, vy, omega |" in page


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("codebase_version", "v2.1", "convert it with threewe data convert"),
        ("codebase_version", None, "codebase_version None"),
        ("total_episodes", 4, "meta/episodes: 3 episodes; meta/info.json says 4"),
        ("total_episodes", True, "total_episodes must be a whole number"),
        ("total_frames", 10**30, "total_frames must be a whole number"),
        ("total_frames", "24", "total_frames must be a whole number"),
        ("fps", 0, "fps must be"),
        ("fps", "fast", "fps must be"),
        ("fps", float("nan"), "NaN is no JSON number"),
        ("features", {}, "features['timestamp'] must be"),
        ("features", [1], "features must be"),
        ("features", {"a": {"dtype": "int64", "shape": [-1]}}, "features['a']: shape [-1] must hold integers"),
        ("features", {"../x": {"dtype": "video", "shape": [1]}}, "'../x' is no name of a feature"),
        ("data_path", "/etc/passwd", "leads out of the dataset"),
        ("video_path", "{video_key.__class__}", "is no field of a path"),
    ],
)
def test_a_wrong_field_is_named(dataset: Path, field: str, value: Any, message: str) -> None:
    change(dataset / "meta/info.json", **{field: value})
    with pytest.raises(ConfigError) as caught:
        open_whole(dataset)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda d: (d / "meta/info.json").unlink(), "meta/info.json: cannot be read"),
        (lambda d: (d / "meta/info.json").write_text("{"), "no JSON"),
        (lambda d: (d / "meta/info.json").write_text("[" * 100_000), "no JSON"),
        (lambda d: (d / "meta/info.json").write_text("[1]"), "must hold a mapping"),
        (lambda d: (d / "meta/info.json").write_bytes(b"\xff"), "can't decode"),
        (lambda d: (d / EPISODES).write_bytes((d / EPISODES).read_bytes()[:-20]), "no Parquet file that can be read"),
        (lambda d: (d / EPISODES).write_bytes(b""), "no Parquet file that can be read"),
        (lambda d: (d / EPISODES).unlink(), "meta/episodes: no Parquet file in it"),
        (lambda d: (d / "data/chunk-000/file-000.parquet").unlink(), "file-000.parquet: missing; episode 0 is in it"),
        (lambda d: (d / f"videos/{CAMERA}/chunk-000/file-000.mp4").unlink(), "file-000.mp4: missing; episode 0"),
        (lambda d: (d / "data/link").symlink_to("/etc/passwd"), "a symbolic link; put the file itself there"),
        (lambda d: (d / "videos/link").symlink_to("/etc"), "a symbolic link; put the file itself there"),
        (lambda d: (d / "images").symlink_to("/etc"), "a symbolic link; put the folder itself there"),
    ],
)
def test_a_broken_dataset_is_one_line(dataset: Path, spoil: Callable[[Path], object], message: str) -> None:
    spoil(dataset)
    with pytest.raises(ConfigError) as caught:
        open_whole(dataset)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("column", "values"),
    [
        ("data/file_index", [0, 0, -1]),
        ("data/file_index", ["0", "0", "../x"]),
        ("data/chunk_index", [None, 0, 0]),
        (f"videos/{CAMERA}/file_index", [0, 10**12, 0]),
        (f"videos/{CAMERA}/from_timestamp", [0.0, float("nan"), 0.0]),
        (f"videos/{CAMERA}/to_timestamp", [-1.0, 0.0, 0.0]),
    ],
)
def test_a_wrong_place_of_an_episode_is_named(dataset: Path, column: str, values: list[Any]) -> None:
    table = pq.read_table(dataset / EPISODES).to_pydict()
    pq.write_table(pa.table({**table, column: values}), dataset / EPISODES)
    with pytest.raises(ConfigError, match=r"must be|are no times in seconds"):
        open_whole(dataset)


@pytest.mark.parametrize("seed", range(60))
def test_no_change_of_a_file_gets_past_as_anything_but_our_error(dataset: Path, seed: int) -> None:
    rng = np.random.default_rng(seed)
    path = dataset / str(rng.choice(["meta/info.json", EPISODES, "meta/tasks.parquet"]))
    content = bytearray(path.read_bytes())
    for _ in range(int(rng.integers(1, 20))):
        content[int(rng.integers(len(content)))] = int(rng.integers(256))
    path.write_bytes(content[: int(rng.integers(1, len(content) + 1))] if rng.random() < 0.3 else content)
    with contextlib.suppress(ConfigError):  # a traceback of anything else prints the seed
        card(open_whole(dataset), "user/name", None, preview=True)


def test_text_of_the_dataset_stays_text_on_the_page(dataset: Path) -> None:
    evil = "x | y\n---\nlicense: mit\n<script>alert(1)</script> [a](javascript:b) `c`"
    pq.write_table(pa.table({"task_index": [0], "task": [evil]}), dataset / "meta/tasks.parquet")
    change(dataset / "meta/info.json", robot_type="<img src=x> | y")
    page = card(open_whole(dataset), "user/name", None, preview=False)
    assert "<script>" not in page
    assert "<img" not in page
    assert "[a](" not in page
    assert page.count("\n---\n") == 1
    assert "license" not in page.split("---")[1]


def test_a_video_that_cannot_be_read_costs_the_picture_alone(dataset: Path) -> None:
    read = open_whole(dataset)
    assert contact_sheet(read) is not None
    (dataset / f"videos/{CAMERA}/chunk-000/file-000.mp4").write_bytes(b"no video")
    assert contact_sheet(read) is None


def png(width: int, height: int, hue: tuple[int, int, int]) -> bytes:
    file = io.BytesIO()
    Image.new("RGB", (width, height), hue).save(file, "PNG")
    return file.getvalue()


def with_images(dataset: Path, images: list[bytes]) -> Dataset:
    """The same dataset, whose camera has images in the data, an episode a row group."""
    fields = json.loads((dataset / "meta/info.json").read_text())
    fields["features"][CAMERA]["dtype"] = "image"
    change(dataset / "meta/info.json", features=fields["features"], video_path=None)
    path = dataset / "data/chunk-000/file-000.parquet"
    cells = [{"bytes": image, "path": None} for image in images for _ in range(8)]
    pq.write_table(pq.read_table(path).append_column(CAMERA, pa.array(cells)), path, row_group_size=8)
    return open_whole(dataset)


def test_images_in_the_data_make_the_picture_too(dataset: Path) -> None:
    sheet = contact_sheet(with_images(dataset, [png(64, 48, hue) for hue in HUES]))
    assert sheet is not None
    with Image.open(io.BytesIO(sheet)) as picture:
        pixels = np.asarray(picture).astype(int)
    for i, hue in enumerate(HUES):
        middle = pixels[pixels.shape[0] // 2, int((i + 0.5) * pixels.shape[1] / 3)]
        assert np.abs(middle - hue).max() < 30, (i, middle)


def test_images_that_are_none_or_of_another_size_cost_the_picture_alone(dataset: Path) -> None:
    assert contact_sheet(with_images(dataset, [b"no image", png(2000, 2000, HUES[0]), b""])) is None
