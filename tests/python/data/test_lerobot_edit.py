"""Datasets made of datasets keep each value, frame and task; a crash or a wrong option leaves what was there."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from data.lerobot_samples import CAMERA, CAMERAS, DEPTH_VIDEO, EVERYTHING, NUMBERS, SMALL, add, episode, write
from threewe.data.lerobot import (
    ArrayFrames,
    Dataset,
    DatasetWriter,
    Episode,
    append,
    convert,
    filter_episodes,
    merge,
    split,
    validate,
)
from threewe.errors import ConfigError

COUNTED = {"episode_index", "index", "task_index"}


def same_episode(found: Episode, wanted: Episode) -> None:
    """All that is not counted in the dataset, to the bit."""
    ours, theirs = found.columns(), wanted.columns()
    for name in theirs.keys() - COUNTED:
        np.testing.assert_array_equal(ours[name], theirs[name], err_msg=name)
    assert found.frame_tasks(ours) == wanted.frame_tasks(theirs)
    for camera in wanted.cameras():
        given, copied = wanted.video(camera), found.video(camera)
        for i in range(wanted.length):
            np.testing.assert_array_equal(copied.image(i), given.image(i))


def same(found: Dataset, wanted: list[Episode]) -> None:
    assert len(found) == len(wanted)
    for ours, theirs in zip(found.episodes, wanted, strict=True):
        same_episode(ours, theirs)
    assert validate(found.root) == []


def contents(root: Path) -> dict[Path, bytes]:
    return {path.relative_to(root): path.read_bytes() for path in root.rglob("*") if path.is_file()}


@pytest.mark.parametrize("codec", ["copy", "av1"])
def test_merged_datasets_have_all_episodes(tmp_path: Path, codec: Any) -> None:
    write(tmp_path / "a", 1, features=EVERYTHING, codec=codec)
    write(tmp_path / "b", 2, (5, 6), ("stop", "turn"), features=EVERYTHING, codec="copy")
    merged = merge([tmp_path / "a", tmp_path / "b"], tmp_path / "both")
    sources = [Dataset.open(tmp_path / name) for name in ("a", "b")]
    same(merged, [each for source in sources for each in source.episodes])
    assert merged.tasks == ("go", "stop", "turn")


def test_there_and_back_between_versions(tmp_path: Path) -> None:
    write(tmp_path / "a", 3, features=EVERYTHING)
    convert(tmp_path / "a", tmp_path / "old", version="v2.1")
    back = convert(tmp_path / "old", tmp_path / "back", version="v3.0")
    same(back, list(Dataset.open(tmp_path / "a").episodes))
    for ours, theirs in zip(back.episodes, Dataset.open(tmp_path / "a").episodes, strict=True):
        noted = ours.stats()
        for name, stats in theirs.stats().items():
            for key, value in stats.items():
                near = 2.0 if name == DEPTH_VIDEO else 1e-9  # [mm] as given, and as decoded
                np.testing.assert_allclose(noted[name][key], value, rtol=1e-9, atol=near, err_msg=f"{name} {key}")


def test_each_copy_of_a_copy_is_the_same_to_the_bit(tmp_path: Path) -> None:
    write(tmp_path / "a", 4)
    convert(tmp_path / "a", tmp_path / "b", version="v3.0")
    convert(tmp_path / "b", tmp_path / "c", version="v3.0")
    assert contents(tmp_path / "b") == contents(tmp_path / "c")


def test_copies_fill_their_files_as_the_original_did(tmp_path: Path) -> None:
    write(tmp_path / "a", 24, (9, 9, 9, 9, 9, 9), ("go",) * 6, video_files_size_in_mb=0.008)
    convert(tmp_path / "a", tmp_path / "b", version="v3.0")
    files = [sorted(contents(tmp_path / name)) for name in ("a", "b")]
    assert files[0] == files[1]
    assert 2 <= sum(path.suffix == ".mp4" for path in files[0]) <= 3


def test_parts_have_their_shares(tmp_path: Path) -> None:
    write(tmp_path / "a", 5, (4, 5, 6, 7, 8), ("go",) * 5, features=NUMBERS)
    train, test = split(tmp_path / "a", {tmp_path / "train": 0.8, tmp_path / "test": 0.2})
    episodes = Dataset.open(tmp_path / "a").episodes
    same(train, list(episodes[:4]))
    same(test, list(episodes[4:]))
    (chosen,) = split(tmp_path / "a", {tmp_path / "chosen": [3, 0]})
    same(chosen, [episodes[3], episodes[0]])
    mixed = split(tmp_path / "a", {tmp_path / "x": 0.6, tmp_path / "y": 0.4}, seed=3)
    assert sorted(each.length for part in mixed for each in part.episodes) == [4, 5, 6, 7, 8]
    again = split(tmp_path / "a", {tmp_path / "x2": 0.6, tmp_path / "y2": 0.4}, seed=3)
    assert [[e.length for e in part.episodes] for part in mixed] == [[e.length for e in p.episodes] for p in again]


FILTERS: list[tuple[dict[str, Any], list[int]]] = [
    ({"tasks": ["go"]}, [0, 2]),
    ({"success": True}, [0, 2]),
    ({"success": False}, [1]),
    ({"min_length": 8}, [0, 1]),
    ({"max_length": 9}, [0, 2]),
    ({"episodes": [2, 1]}, [1, 2]),
    ({"tasks": ["go", "stop"], "min_length": 8, "success": True}, [0]),
    ({"keep": lambda each: each.index == 1}, [1]),
]


@pytest.mark.parametrize(("conditions", "kept"), FILTERS)
def test_filtered_episodes_are_those_that_meet_all(tmp_path: Path, conditions: dict[str, Any], kept: list[int]) -> None:
    write(tmp_path / "a", 6, features=NUMBERS)
    found = filter_episodes(tmp_path / "a", tmp_path / "b", **conditions)
    same(found, [Dataset.open(tmp_path / "a").episodes[i] for i in kept])


@pytest.mark.parametrize("version", ["v3.0", "v2.1"])
def test_appended_episodes_follow_the_others(tmp_path: Path, version: Any) -> None:
    write(tmp_path / "a", 7, features=EVERYTHING, version=version)
    write(tmp_path / "b", 8, (5, 6), ("stop", "turn"), features=EVERYTHING)
    before = convert(tmp_path / "a", tmp_path / "copy", version=version)
    found = append(tmp_path / "a", [tmp_path / "b", tmp_path / "copy"])
    added = [*Dataset.open(tmp_path / "b").episodes, *before.episodes]
    same(found, [*before.episodes, *added])
    assert found.tasks == ("go", "stop", "turn")


def test_statistics_of_all_are_those_of_one_dataset(tmp_path: Path) -> None:
    """Appending, merging and writing at once come to the same."""
    write(tmp_path / "a", 9)
    write(tmp_path / "b", 10, (5, 6), ("stop", "turn"))
    merged = merge([tmp_path / "a", tmp_path / "b"], tmp_path / "both")
    appended = append(tmp_path / "a", [tmp_path / "b"])
    assert merged.stats().keys() == appended.stats().keys()
    for name, stats in merged.stats().items():
        for key, value in stats.items():
            np.testing.assert_allclose(appended.stats()[name][key], value, rtol=1e-9, atol=1e-12, err_msg=name)
    columns = [each.columns()["action"] for each in merged.episodes]
    np.testing.assert_allclose(merged.stats()["action"]["mean"], np.concatenate(columns).mean(0), atol=1e-6)
    np.testing.assert_allclose(merged.stats()["action"]["std"], np.concatenate(columns).std(0), atol=1e-6)


DIFFERENT: list[tuple[dict[str, Any], str]] = [
    ({"features": NUMBERS}, "only one has observation.images.front"),
    (
        {"features": {**SMALL, "action": {"dtype": "float64", "shape": [2], "names": ["v", "omega"]}}},
        "action has dtype",
    ),
    ({"features": {**SMALL, "action": {"dtype": "float32", "shape": [2], "names": ["a", "b"]}}}, "action has names"),
]


@pytest.mark.parametrize(("change", "message"), DIFFERENT)
def test_datasets_that_differ_are_not_merged(tmp_path: Path, change: dict[str, Any], message: str) -> None:
    write(tmp_path / "a", 11)
    write(tmp_path / "b", 12, **change)
    for make in (
        lambda: merge([tmp_path / "a", tmp_path / "b"], tmp_path / "c"),
        lambda: append(tmp_path / "a", [tmp_path / "b"]),
    ):
        with pytest.raises(ConfigError, match=message):
            make()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a", "b"]
    assert validate(tmp_path / "a") == []


def mounted(*place: float) -> dict[str, Any]:
    """The features, with a camera that is somewhere on the robot."""
    info = {"info": {"base_from_sensor": list(place), "height": 0.1}} if place else {}
    return {**SMALL, CAMERA: {**SMALL[CAMERA], **info}}


def test_datasets_are_not_merged_whose_sensors_are_mounted_elsewhere(tmp_path: Path) -> None:
    write(tmp_path / "a", 1, features=mounted(0.1, 0.0, 0.0))
    write(tmp_path / "b", 2, features=mounted(0.1, 0.0, 0.2))
    write(tmp_path / "c", 3, features=mounted())
    with pytest.raises(ConfigError, match=rf"b: the sensor of {CAMERA} is mounted elsewhere than that of .*a"):
        merge([tmp_path / "a", tmp_path / "b"], tmp_path / "d")
    made = merge([tmp_path / "a", tmp_path / "c"], tmp_path / "d")
    assert made.features[CAMERA].mount == ([0.1, 0.0, 0.0], 0.1)
    assert validate(tmp_path / "d") == []


def test_wrong_wishes_are_refused_and_leave_nothing(tmp_path: Path) -> None:
    write(tmp_path / "a", 13, features=NUMBERS)
    wishes = [
        (
            lambda: filter_episodes(tmp_path / "a", tmp_path / "b", tasks=["fly"]),
            "no task 'fly'; there are 'go', 'stop'",
        ),
        (lambda: filter_episodes(tmp_path / "a", tmp_path / "b", min_length=99), "no episode of 3 meets"),
        (lambda: filter_episodes(tmp_path / "a", tmp_path / "b", episodes=[7]), "no episode 7; there are 0 to 2"),
        (lambda: split(tmp_path / "a", {tmp_path / "b": 0.7, tmp_path / "c": 0.7}), "shares"),
        (lambda: split(tmp_path / "a", {tmp_path / "b": 0.01}), "no episode is left"),
        (lambda: split(tmp_path / "a", {tmp_path / "b": [3]}), "no episode 3"),
        (lambda: merge([], tmp_path / "b"), "no dataset was given"),
        (lambda: merge([tmp_path / "a"], tmp_path / "a"), "exists already"),
        (lambda: convert(tmp_path / "nobody", tmp_path / "b", version="v2.1"), "no LeRobot dataset"),
    ]
    for wish, message in wishes:
        with pytest.raises(ConfigError, match=message):
            wish()
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


def test_success_is_asked_of_a_dataset_that_does_not_say(tmp_path: Path) -> None:
    features = {name: feature for name, feature in NUMBERS.items() if name != "next.success"}
    write(tmp_path / "a", 14, features=features)
    with pytest.raises(ConfigError, match="which episodes succeeded"):
        filter_episodes(tmp_path / "a", tmp_path / "b", success=True)


def test_appending_that_is_killed_leaves_the_dataset_as_it_was(tmp_path: Path) -> None:
    write(tmp_path / "a", 15)
    before = contents(tmp_path / "a")
    program = """
import os, signal, sys
sys.path.insert(0, sys.argv[2])
import numpy as np
from threewe.data.lerobot import DatasetWriter
from lerobot_samples import add, episode
from threewe.data.lerobot import writer as module
if sys.argv[3] == "late":  # all is written, and the folders are about to change places
    module.replace_folder = lambda *_: os.kill(os.getpid(), signal.SIGKILL)
writer = DatasetWriter.append(sys.argv[1])
add(writer, episode(np.random.default_rng(0), 5))
if sys.argv[3] == "late":
    writer.close()
os.kill(os.getpid(), signal.SIGKILL)
"""
    for moment in ("early", "late"):
        words = [sys.executable, "-c", program, str(tmp_path / "a"), str(Path(__file__).parent), moment]
        assert subprocess.run(words).returncode == -signal.SIGKILL
        assert contents(tmp_path / "a") == before
    assert validate(tmp_path / "a") == []


def test_of_two_that_append_at_once_the_second_is_told(tmp_path: Path) -> None:
    write(tmp_path / "a", 16)
    rng = np.random.default_rng(0)
    late = DatasetWriter.append(tmp_path / "a")
    add(late, episode(rng, 5))
    with DatasetWriter.append(tmp_path / "a") as early:
        add(early, episode(rng, 6))
    with pytest.raises(ConfigError, match="was changed"):
        late.close()
    assert len(Dataset.open(tmp_path / "a")) == 4
    assert validate(tmp_path / "a") == []
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


def test_what_is_appended_is_encoded_like_the_rest(tmp_path: Path) -> None:
    write(tmp_path / "a", 17, codec="av1")
    with DatasetWriter.append(tmp_path / "a") as writer:
        add(writer, episode(np.random.default_rng(0), 5))
    found = Dataset.open(tmp_path / "a")
    assert found.features[CAMERA].info["video.codec"] == "av1"
    assert validate(tmp_path / "a") == []


def test_depth_keeps_the_scale_that_it_was_given(tmp_path: Path) -> None:
    near = {"is_depth_map": True, "video.depth_max": 4.0, "video.use_log": False}
    feature = {"dtype": "video", "shape": [48, 64, 1], "names": None, "info": near}
    depth = np.random.default_rng(25).integers(300, 3900, (6, 48, 64)).astype(np.uint16)
    with DatasetWriter(tmp_path / "a", fps=10, features={DEPTH_VIDEO: feature}) as writer:
        writer.add_episode({}, "go", {DEPTH_VIDEO: ArrayFrames(depth)})
    convert(tmp_path / "a", tmp_path / "b", version="v3.0")
    for name in ("a", "b"):
        found = Dataset.open(tmp_path / name)
        assert found.features[DEPTH_VIDEO].info["video.depth_max"] == 4.0
        source = found.episodes[0].video(DEPTH_VIDEO)
        read = np.array([source.image(i) for i in range(6)]).astype(int)
        assert np.abs(read - depth).max() <= 1  # [mm] half a step of 4 m / 4095
        assert validate(tmp_path / name) == []


def test_other_files_of_a_folder_stay_when_something_is_appended(tmp_path: Path) -> None:
    write(tmp_path / "a", 18)
    write(tmp_path / "b", 19)
    (tmp_path / "a/README.md").write_text("a card")
    append(tmp_path / "a", [tmp_path / "b"])
    assert (tmp_path / "a/README.md").read_text() == "a card"


def test_a_link_out_of_a_dataset_is_not_followed_when_something_is_appended(tmp_path: Path) -> None:
    write(tmp_path / "a", 20)
    (tmp_path / "a/README.md").symlink_to("/etc/hostname")
    with pytest.raises(ConfigError, match="leads out of the dataset"):
        DatasetWriter.append(tmp_path / "a")
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


def test_where_hard_links_fail_files_are_copied(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: Any) -> None:
        raise OSError("no links here")

    write(tmp_path / "a", 21)
    write(tmp_path / "b", 22)
    monkeypatch.setattr(os, "link", refuse)
    monkeypatch.setattr("threewe.data.lerobot.replacing.exchange", lambda *_: False)
    assert len(append(tmp_path / "a", [tmp_path / "b"])) == 6
    assert validate(tmp_path / "a") == []
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a", "b"]


def test_images_in_the_table_are_copied_as_they_are(tmp_path: Path) -> None:
    write(tmp_path / "a", 23, features=EVERYTHING)
    shutil.copytree(tmp_path / "a", tmp_path / "b")
    merged = merge([tmp_path / "a", tmp_path / "b"], tmp_path / "c")
    same(merged, [*Dataset.open(tmp_path / "a").episodes] * 2)
    assert set(CAMERAS) <= set(merged.features)
