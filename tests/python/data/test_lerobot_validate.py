"""Whatever is wrong in a LeRobot dataset is found, and named with file and row; hostile ones are refused."""

from __future__ import annotations

import json
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from data.lerobot_samples import CAMERA, EVERYTHING, FPS, SMALL, write
from threewe.data.lerobot import Dataset, Feature, validate
from threewe.data.lerobot.stats import column_stats, frames_stats, sampled_frames
from threewe.errors import ConfigError

from verify.cases import hostile_datasets

DATA, EPISODES = "data/chunk-000/file-000.parquet", "meta/episodes/chunk-000/file-000.parquet"
VIDEO = f"videos/{CAMERA}/chunk-000/file-000.mp4"


def set_cell(file: str, column: str, row: int, value: Any) -> Callable[[Path], None]:
    def change(root: Path) -> None:
        table = pq.read_table(root / file)
        values = table.column(column).to_pylist()
        values[row] = value
        array = pa.array(values, table.schema.field(column).type)
        pq.write_table(table.set_column(table.schema.names.index(column), column, array), root / file)

    return change


def set_info(**values: Any) -> Callable[[Path], None]:
    def change(root: Path) -> None:
        path = root / "meta/info.json"
        path.write_text(json.dumps({**json.loads(path.read_text()), **values}))

    return change


def set_stats(feature: str, key: str, value: Any) -> Callable[[Path], None]:
    def change(root: Path) -> None:
        path = root / "meta/stats.json"
        stats = json.loads(path.read_text())
        stats[feature][key] = value
        path.write_text(json.dumps(stats))

    return change


def swap_videos(root: Path) -> None:
    """Frames of other episodes: as many, and quite different."""
    from threewe.data.lerobot import ArrayFrames
    from threewe.data.lerobot.clips import encode

    dark = ArrayFrames(np.zeros((28, 48, 64, 3), np.uint8))
    encode(dark, root / VIDEO, FPS, "h264", {})


def longer_video(root: Path) -> None:
    from threewe.data.lerobot import ArrayFrames
    from threewe.data.lerobot.clips import encode

    encode(ArrayFrames(np.zeros((31, 48, 64, 3), np.uint8)), root / VIDEO, FPS, "h264", {})


BEGIN = f"videos/{CAMERA}/from_timestamp"
FAULTS: list[tuple[str, Callable[[Path], None], str, int | None, str]] = [
    ("time", set_cell(DATA, "timestamp", 11, 0.35), DATA, 11, "timestamp 0.35 s; at 10 frames a second it must be 0.2"),
    ("frame", set_cell(DATA, "frame_index", 4, 9), DATA, 4, "frame_index 9; it must be 4"),
    ("index", set_cell(DATA, "index", 20, 3), DATA, 20, "index 3; it must be 20"),
    ("nan", set_cell(DATA, "action", 13, [0.0, float("nan")]), DATA, 13, "action is not finite"),
    ("task", set_cell(DATA, "task_index", 2, 1), "meta/episodes", 0, "tasks ['go']; its frames have ['go', 'stop']"),
    ("no task", set_cell(DATA, "task_index", 2, 5), DATA, 2, "task_index 5; there are 2 tasks"),
    ("rows", set_cell(DATA, "episode_index", 9, 0), DATA, None, "10 rows of episode 0; the metadata says 9"),
    ("length", set_cell(EPISODES, "length", 1, 11), EPISODES, 1, "dataset_to_index 21; with 11 frames it must be 20"),
    ("gap", set_cell(EPISODES, "dataset_from_index", 2, 22), EPISODES, 2, "dataset_to_index 28; with 7 "),
    ("moment", set_cell(EPISODES, BEGIN, 1, 1.0), "meta/episodes", 1, "12 frames take"),
    ("mean", set_cell(EPISODES, "stats/action/mean", 1, [0.5, 0.0]), "meta/episodes", 1, "stats/action/mean[0] is 0.5"),
    ("count", set_cell(EPISODES, "stats/action/count", 2, [8]), "meta/episodes", 2, "stats/action/count is 8; "),
    ("max", set_stats("action", "max", [9.0, 1.0]), "meta/stats.json", None, "action/max[0] is 9"),
    ("frames", set_info(total_frames=29), "meta/episodes", None, "lengths add up to 28; meta/info.json says 29 frames"),
    ("episodes", set_info(total_episodes=4), "meta/episodes", None, "3 episodes; meta/info.json says 4"),
    ("tasks", set_info(total_tasks=3), "meta/tasks.parquet", None, "2 tasks; meta/info.json says 3"),
    ("splits", set_info(splits={"train": "0:9"}), "meta/info.json", None, "must be within 0:3"),
    ("orphan", lambda root: (root / "data/left.parquet").write_text("x"), "data/left.parquet", None, "no episode"),
    ("other video", swap_videos, "meta/episodes", 0, f"stats/{CAMERA}/mean[0] is"),
    ("longer video", longer_video, VIDEO, None, "31 frames (31 by its header); its episodes have 28"),
]  # fmt: skip


@pytest.mark.parametrize(("change", "file", "row", "what"), [f[1:] for f in FAULTS], ids=[f[0] for f in FAULTS])
def test_each_fault_is_named(
    tmp_path: Path, change: Callable[[Path], None], file: str, row: int | None, what: str
) -> None:
    write(tmp_path / "a", 1)
    assert validate(tmp_path / "a") == []
    change(tmp_path / "a")
    problems = validate(tmp_path / "a")
    assert any(problem.file == file and problem.row == row and what in problem.what for problem in problems), problems


def test_a_video_that_is_damaged_inside_is_noticed(tmp_path: Path) -> None:
    write(tmp_path / "a", 2)
    path = tmp_path / "a" / VIDEO
    content = bytearray(path.read_bytes())
    middle = content.index(b"mdat") + 3000
    content[middle : middle + 2000] = random.Random(2).randbytes(2000)
    path.write_bytes(content)
    assert any(problem.file == VIDEO for problem in validate(tmp_path / "a"))


def test_older_versions_are_validated_too(tmp_path: Path) -> None:
    write(tmp_path / "a", 3, version="v2.1")
    assert validate(tmp_path / "a") == []
    path = tmp_path / "a/meta/episodes.jsonl"
    lines = path.read_text().splitlines()
    path.write_text("\n".join([lines[0], lines[1].replace('"length": 12', '"length": "x"'), lines[2]]))
    (problem,) = validate(tmp_path / "a")
    assert (problem.file, problem.row) == ("meta/episodes.jsonl", 2)
    assert "length must be a whole number" in problem.what


def test_what_is_no_dataset_is_one_problem(tmp_path: Path) -> None:
    (problem,) = validate(tmp_path)
    assert "no LeRobot dataset" in problem.what


def test_hostile_datasets_are_refused_and_nothing_else_happens() -> None:
    """A sample of them, and of drawn ones."""
    seed = 21
    for name, attack in random.Random(seed).sample(list(hostile_datasets.cases(seed)), 25):
        if "bomb" in name or "4096" in name:
            continue  # what takes a second, or memory, is for verify
        outcome = hostile_datasets.meet(name, attack, seed)
        assert outcome["refused"], (seed, name)
        assert "\n" not in outcome["refused"], (seed, name)
        assert outcome["untouched"], (seed, name)
        assert not outcome["leaked"], (seed, name)


def test_a_sound_dataset_is_not_refused(tmp_path: Path) -> None:
    hostile_datasets.read_everything(hostile_datasets.sound_dataset(tmp_path / "a"))


def test_columns_of_other_writers_are_read(tmp_path: Path) -> None:
    """Lists of any length, large ones and rows of one group are what other tools write."""
    write(tmp_path / "a", 4)
    before = [each.columns() for each in Dataset.open(tmp_path / "a").episodes]
    table = pq.read_table(tmp_path / "a" / DATA)
    for name in ("action", "observation.state"):
        kind = pa.large_list(pa.float32()) if name == "action" else pa.list_(pa.float32())
        array = pa.array(table.column(name).to_pylist(), kind)
        table = table.set_column(table.schema.names.index(name), name, array)
    pq.write_table(table.replace_schema_metadata(None), tmp_path / "a" / DATA)
    assert validate(tmp_path / "a") == []
    for wanted, found in zip(before, Dataset.open(tmp_path / "a").episodes, strict=True):
        for name, values in found.columns().items():
            np.testing.assert_array_equal(values, wanted[name])


def test_frames_are_read_in_any_order(tmp_path: Path) -> None:
    write(tmp_path / "a", 5, features=EVERYTHING, codec="h264")
    rng = random.Random(5)
    for episode in Dataset.open(tmp_path / "a").episodes:
        for camera in episode.cameras():
            in_order = [episode.video(camera).image(i).copy() for i in range(episode.length)]
            source = episode.video(camera)
            for i in rng.choices(range(episode.length), k=12):
                np.testing.assert_array_equal(source.image(i), in_order[i], err_msg=f"{camera} {i}")
            with pytest.raises((IndexError, ConfigError)):
                source.image(episode.length)


def test_statistics_against_sorting() -> None:
    """LeRobot's quantiles are within a bin of the sorted values; the rest is exact."""
    for seed in range(50):
        rng = np.random.default_rng(seed)
        values = rng.normal(rng.uniform(-5, 5), rng.uniform(0.1, 3), (rng.integers(2, 400), 3)).astype(np.float32)
        stats = column_stats(values)
        np.testing.assert_allclose(stats["mean"], values.mean(0, dtype=float), rtol=1e-12, err_msg=f"seed {seed}")
        np.testing.assert_allclose(stats["std"], values.std(0, dtype=float), rtol=1e-9, err_msg=f"seed {seed}")
        np.testing.assert_array_equal(stats["min"], values.min(0))
        ordered = np.sort(values, axis=0)
        for name, share in (("q01", 0.01), ("q10", 0.1), ("q50", 0.5), ("q90", 0.9), ("q99", 0.99)):
            place = max(int(np.ceil(share * len(values))) - 1, 0)
            width = (values.max(0) - values.min(0)) / 5000 * 2
            assert (np.abs(stats[name] - ordered[place]) <= width + 1e-6).all(), (seed, name)


def test_statistics_of_images_against_all_pixels() -> None:
    rng = np.random.default_rng(6)
    frames = rng.integers(0, 256, (5, 20, 30, 3), np.uint8)
    stats = frames_stats(lambda i: frames[i], len(frames), Feature("video", (20, 30, 3)))
    np.testing.assert_allclose(stats["mean"].ravel(), frames.mean((0, 1, 2)) / 255, rtol=1e-12)
    np.testing.assert_allclose(stats["std"].ravel(), frames.std((0, 1, 2)) / 255, rtol=1e-12)
    assert stats["count"] == [5]
    assert sampled_frames(50) == list(range(50))
    assert len(sampled_frames(250)) == 100
    assert len(sampled_frames(5000)) == 594


def test_a_dataset_with_no_camera_is_read(tmp_path: Path) -> None:
    write(tmp_path / "a", 7, features={name: SMALL[name] for name in ("action", "next.success")})
    info = json.loads((tmp_path / "a/meta/info.json").read_text())
    assert info["video_path"] is None
    assert validate(tmp_path / "a") == []
