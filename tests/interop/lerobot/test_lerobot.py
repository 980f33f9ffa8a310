"""LeRobot loads what we write, trains on it and continues it; we read what it writes. `./dev interop lerobot`."""

from __future__ import annotations

import asyncio
import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from threewe import Robot
from threewe.data import Recording, TrajectoryRecorder
from threewe.data.exporting import Rows
from threewe.data.lerobot import (
    ArrayFrames,
    Dataset,
    DatasetWriter,
    FrameSource,
    PacketFrames,
    append,
    convert,
    validate,
)
from threewe.data.video import KeyFrameEncoder

from tests.interop.lerobot import samples
from tests.interop.lerobot.asking import Ask, peer_of
from tests.interop.lerobot.samples import CAMERA, DEPTH, DEPTH_VIDEO, FEATURES, FPS, STILL, TASKS

DELTAS = {"action": [0.0, 0.1, 0.2], CAMERA: [-0.1, 0.0]}
IMAGES = (CAMERA, STILL, DEPTH, DEPTH_VIDEO)


@pytest.fixture(scope="module")
def lerobot() -> Iterator[Ask]:
    """LeRobot in a process of its own."""
    with peer_of("peer.py") as ask:
        yield ask


def sources(given: dict[str, Any], packets: bool) -> dict[str, FrameSource]:
    """Frames of an episode's cameras; of colours as a recorder has them."""
    found: dict[str, FrameSource] = {name: ArrayFrames(given[name]) for name in IMAGES}
    if packets:
        shape = (*samples.SIZE, 3)
        encoder = KeyFrameEncoder(shape, "rgb24")
        found[CAMERA] = PacketFrames([encoder.encode(image) for image in given[CAMERA]], shape)
    return found


def write_ours(root: Path, seed: int, codec: Any, version: Any = "v3.0") -> None:
    with DatasetWriter(
        root, fps=FPS, features=FEATURES, robot_type=samples.ROBOT, codec=codec, version=version
    ) as writer:
        for task, given in zip(TASKS, samples.episodes(seed), strict=True):
            numbers = {name: values for name, values in given.items() if name not in IMAGES}
            writer.add_episode(numbers, task, sources(given, packets=codec == "copy"))


def write_theirs(lerobot: Ask, root: Path, seed: int) -> None:
    arrays = pack(root.with_suffix(".npz"), seed)
    lerobot("write", root=root, arrays=arrays, features=FEATURES, fps=FPS, tasks=list(TASKS), robot_type=samples.ROBOT)


def pack(path: Path, seed: int) -> Path:
    given = samples.episodes(seed)
    np.savez(path, **{f"{i}/{name}": values for i, each in enumerate(given) for name, values in each.items()})
    return path


def same_as_lerobot_reads(lerobot: Ask, root: Path, tmp_path: Path) -> dict[str, Any]:
    """Compares every value, pixel, time and task, and the neighbours in time; LeRobot's statistics."""
    arrays = tmp_path / f"{root.name}-read.npz"
    answer = lerobot("load", root=root, arrays=arrays, deltas=DELTAS)
    theirs, ours = read(arrays), Dataset.open(root)
    assert (answer["frames"], answer["episodes"]) == (ours.info.total_frames, len(ours))
    start = 0
    for episode in ours.episodes:
        rows = slice(start, start + episode.length)
        columns = episode.columns()
        for name, values in columns.items():
            single = values.astype(np.float32) if values.dtype == float else values  # as PyTorch takes lists
            np.testing.assert_array_equal(theirs[name][rows], single, err_msg=name)
        assert theirs["task"][rows].tolist() == episode.frame_tasks(columns)
        for name in IMAGES:
            images = np.array([episode.video(name).image(i) for i in range(episode.length)])
            same_images(theirs[name][rows], images, name)
        steps = np.arange(episode.length)
        for k, ahead in enumerate((0, 1, 2)):
            inside = np.minimum(steps + ahead, episode.length - 1)
            np.testing.assert_array_equal(theirs["delta/action"][rows][:, k], columns["action"][inside])
            np.testing.assert_array_equal(theirs["pad/action"][rows][:, k], steps + ahead >= episode.length)
        camera = np.array([episode.video(CAMERA).image(max(i - 1, 0)) for i in steps])
        same_images(theirs[f"delta/{CAMERA}"][rows][:, 0], camera, "the frame before")
        start += episode.length
    return answer


def read(path: Path) -> dict[str, Any]:
    with np.load(path) as arrays:
        return dict(arrays)


def same_images(theirs: Any, ours: Any, what: str) -> None:
    """LeRobot's (frames, channels, height, width): colours in 0 to 1, depth in millimetres."""
    if ours.ndim == 3:
        np.testing.assert_allclose(theirs[:, 0], ours, atol=1.0, err_msg=what)
    else:
        levels = np.moveaxis(theirs, 1, 3) * 255
        # another FFmpeg may round a colour otherwise
        np.testing.assert_allclose(levels, ours, atol=2.01, err_msg=what)


@pytest.mark.parametrize("codec", ["copy", "av1", "h264"])
def test_lerobot_loads_each_frame_of_ours(lerobot: Ask, tmp_path: Path, codec: str) -> None:
    write_ours(tmp_path / "ours", 1, codec)
    same_as_lerobot_reads(lerobot, tmp_path / "ours", tmp_path)


def test_depth_images_lose_nothing_on_the_way_to_lerobot(lerobot: Ask, tmp_path: Path) -> None:
    write_ours(tmp_path / "ours", 2, "copy")
    lerobot("load", root=tmp_path / "ours", arrays=tmp_path / "read.npz", deltas=DELTAS)
    given = np.concatenate([each[DEPTH] for each in samples.episodes(2)])
    np.testing.assert_array_equal(read(tmp_path / "read.npz")[DEPTH][:, 0], given)


def test_red_is_red_in_lerobots_tensor(lerobot: Ask, tmp_path: Path) -> None:
    write_ours(tmp_path / "ours", 3, "copy")
    lerobot("load", root=tmp_path / "ours", arrays=tmp_path / "read.npz", deltas=DELTAS)
    frame = read(tmp_path / "read.npz")[CAMERA][0]
    np.testing.assert_allclose(frame[:, 30:50, 10:30].mean((1, 2)) * 255, (210, 20, 25), atol=0.05 * 255)


def test_lerobot_trains_act_on_ours(lerobot: Ask, tmp_path: Path) -> None:
    given = samples.episodes(4)
    names = ("observation.state", "action", CAMERA)
    features = {name: FEATURES[name] for name in names}
    with DatasetWriter(tmp_path / "ours", fps=FPS, features=features, robot_type=samples.ROBOT) as writer:
        for task, each in zip(TASKS, given, strict=True):
            numbers = {name: each[name] for name in names[:2]}
            writer.add_episode(numbers, task, {CAMERA: sources(each, packets=True)[CAMERA]})
    answer = lerobot("train", root=tmp_path / "ours", output=tmp_path / "trained", steps=3)
    assert answer["checkpoints"] == ["model.safetensors"]


def test_we_read_and_validate_what_lerobot_wrote(lerobot: Ask, tmp_path: Path) -> None:
    write_theirs(lerobot, tmp_path / "theirs", 5)
    assert validate(tmp_path / "theirs") == []
    same_as_lerobot_reads(lerobot, tmp_path / "theirs", tmp_path)
    for episode, given in zip(Dataset.open(tmp_path / "theirs").episodes, samples.episodes(5), strict=True):
        for name, values in episode.columns().items():
            if name in given:
                assert values.dtype == given[name].dtype or name == "note"
                np.testing.assert_array_equal(values, given[name])
        depth = np.array([episode.video(DEPTH).image(i) for i in range(episode.length)])
        np.testing.assert_array_equal(depth, given[DEPTH])


def test_statistics_are_those_of_lerobot(lerobot: Ask, tmp_path: Path) -> None:
    write_theirs(lerobot, tmp_path / "theirs", 6)
    write_ours(tmp_path / "ours", 6, "av1")
    theirs, ours = Dataset.open(tmp_path / "theirs"), Dataset.open(tmp_path / "ours")
    pairs = [(a.stats(), b.stats()) for a, b in zip(theirs.episodes, ours.episodes, strict=True)]
    for their, our in [*pairs, (theirs.stats(), ours.stats())]:
        assert their.keys() == our.keys()
        for name in their:
            assert their[name].keys() == our[name].keys()
            for key, value in their[name].items():
                assert value.shape == our[name][key].shape
                # theirs are added in single precision; quantiles count in bins of 1/5000 of the range
                scale = float((our[name]["max"] - our[name]["min"]).max()) or 1.0
                np.testing.assert_allclose(our[name][key], value, rtol=1e-4, atol=1e-3 * scale, err_msg=f"{name} {key}")


def test_the_files_are_those_of_lerobot(lerobot: Ask, tmp_path: Path) -> None:
    """Same tree, same info.json, same types and metadata of all tables, same stream parameters."""
    import pyarrow.parquet as pq

    write_theirs(lerobot, tmp_path / "theirs", 7)
    write_ours(tmp_path / "ours", 7, "av1")
    trees = [
        sorted(p.relative_to(root) for p in root.rglob("*") if p.is_file())
        for root in (tmp_path / "theirs", tmp_path / "ours")
    ]
    assert trees[0] == trees[1]
    infos = [json.loads((tmp_path / name / "meta/info.json").read_text()) for name in ("theirs", "ours")]
    assert infos[1] == infos[0]
    assert list(infos[1]) == list(infos[0])
    for file in (path for path in trees[0] if path.suffix == ".parquet"):
        tables = [pq.ParquetFile(tmp_path / name / file) for name in ("theirs", "ours")]
        schemas = [table.schema_arrow for table in tables]
        assert schemas[1].equals(schemas[0]), file
        assert [plain(schema.metadata) for schema in schemas][1] == plain(schemas[0].metadata), file
        assert tables[1].num_row_groups == tables[0].num_row_groups, file


def plain(metadata: dict[bytes, bytes] | None) -> dict[str, Any]:
    """A schema's metadata without fingerprints and versions of writers."""
    found = {key.decode(): json.loads(value) for key, value in (metadata or {}).items()}
    for entry in found.values():
        for name in ("fingerprint", "creator", "pandas_version"):
            entry.pop(name, None)
    return found


@pytest.mark.parametrize("codec", ["copy", "av1"])
def test_lerobot_reads_what_we_appended_to_its_dataset(lerobot: Ask, tmp_path: Path, codec: str) -> None:
    write_theirs(lerobot, tmp_path / "both", 8)
    write_ours(tmp_path / "ours", 9, codec)
    before = lerobot("load", root=tmp_path / "both", arrays=tmp_path / "before.npz", deltas=DELTAS)
    append(tmp_path / "both", [tmp_path / "ours"])
    assert validate(tmp_path / "both") == []
    answer = same_as_lerobot_reads(lerobot, tmp_path / "both", tmp_path)
    assert answer["frames"] == 2 * before["frames"]
    old, new = read(tmp_path / "before.npz"), read(tmp_path / "both-read.npz")
    for name in old:
        np.testing.assert_array_equal(new[name][: before["frames"]], old[name])


def test_lerobot_continues_our_dataset(lerobot: Ask, tmp_path: Path) -> None:
    write_ours(tmp_path / "both", 10, "av1")
    lerobot("resume", root=tmp_path / "both", arrays=pack(tmp_path / "more.npz", 11), tasks=list(TASKS))
    assert validate(tmp_path / "both") == []
    assert same_as_lerobot_reads(lerobot, tmp_path / "both", tmp_path)["episodes"] == 6


def test_lerobot_converts_our_version_2_1(lerobot: Ask, tmp_path: Path) -> None:
    features = {name: FEATURES[name] for name in ("observation.state", "action", CAMERA)}
    with DatasetWriter(tmp_path / "old", fps=FPS, features=features, version="v2.1") as writer:
        for task, each in zip(TASKS, samples.episodes(12), strict=True):
            numbers = {name: each[name] for name in ("observation.state", "action")}
            writer.add_episode(numbers, task, {CAMERA: sources(each, packets=True)[CAMERA]})
    convert(tmp_path / "old", tmp_path / "ours", version="v3.0")
    shutil.copytree(tmp_path / "old", tmp_path / "theirs")
    lerobot("convert", root=tmp_path / "theirs")
    found = []
    for name in ("ours", "theirs"):
        lerobot("load", root=tmp_path / name, arrays=tmp_path / f"{name}.npz", deltas=DELTAS)
        found.append(read(tmp_path / f"{name}.npz"))
        assert validate(tmp_path / name) == []
    for name in found[0]:
        np.testing.assert_array_equal(found[0][name], found[1][name], err_msg=name)


def test_lerobot_loads_what_a_robot_recorded(lerobot: Ask, tmp_path: Path) -> None:
    """From the robot's journal to LeRobot's tensors."""

    async def drive() -> None:
        async with Robot(image_size=samples.SIZE) as robot:
            with TrajectoryRecorder(robot, tmp_path / "recording") as recorder:
                for x, y in ((2.0, 1.0), (0.5, 0.5)):
                    recorder.start_episode("go to the kitchen")
                    recorder.end_episode(success=bool(await robot.move_to(x, y)))
                recorder.export(tmp_path / "dataset", fps=10)

    asyncio.run(drive())
    lerobot("load", root=tmp_path / "dataset", arrays=tmp_path / "read.npz", deltas={"action": [0.0, 0.1]})
    theirs = read(tmp_path / "read.npz")
    start = 0
    for episode in Recording(tmp_path / "recording"):
        rows = Rows.of(episode, 10.0)
        count, camera = len(rows.time), episode.camera()
        shown = np.array([camera.color(i)[..., ::-1] for i in rows.samples(camera.received)])
        same_images(theirs["observation.images.camera"][start : start + count], shown, "camera")
        np.testing.assert_allclose(
            theirs["observation.state"][start : start + count, :3], episode.pose[rows.ticks], atol=1e-5
        )
        np.testing.assert_array_equal(theirs["action"][start : start + count], rows.following(episode.executed))
        start += count
    assert start == len(theirs["action"])
