"""Files that were forged, cut off or are no files at all: one ConfigError that says where, never more than seconds."""

from __future__ import annotations

import contextlib
import json
import os
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import threewe
from threewe import ConfigError, ContractError, _core
from threewe.benchmark import load_episodes
from threewe.slam import Relations, Slam, load_map, read_carmen, read_log

from tests.fuzz.python_fuzzer import CORPUS, mutate

FLASER = "FLASER 4 {ranges} {laser} {robot} {time} nohost {time}\n"

READERS: dict[str, Callable[[Path], object]] = {
    "log": read_log,
    "relations": Relations.read,
    "json": load_episodes,
    "slam": Slam.load,
    "yaml": load_map,
}


def log_of(**fields: str) -> str:
    good = {"ranges": "1 2 3 4", "laser": "0 0 0", "robot": "0 0 0", "time": "1"}
    return FLASER.format(**good) + FLASER.format(**{**good, "time": "2", **fields})


@pytest.mark.parametrize("suffix", READERS)
def test_devices_pipes_and_folders_are_no_files(suffix: str, tmp_path: Path) -> None:
    pipe, device, folder = (tmp_path / f"{name}.{suffix}" for name in ("pipe", "device", "folder"))
    os.mkfifo(pipe)
    device.symlink_to("/dev/zero")
    folder.mkdir()
    for path in (pipe, device, folder, tmp_path / f"none.{suffix}"):
        with pytest.raises(ConfigError, match=path.stem):
            READERS[suffix](path)


def test_a_bag_with_a_pipe_in_it(tmp_path: Path) -> None:
    pytest.importorskip("rosbags", reason="not shown: needs rosbags")
    os.mkfifo(tmp_path / "metadata.yaml")
    with pytest.raises(ConfigError, match=r"metadata\.yaml: not a file"):
        read_log(tmp_path)


def test_a_line_without_an_end(tmp_path: Path) -> None:
    (tmp_path / "long.log").write_text(log_of() + "FLASER 180 " + "1 " * 2**20)
    with pytest.raises(ConfigError, match=r"long\.log:3: a line of more than"):
        read_log(tmp_path / "long.log")


@pytest.mark.parametrize(
    "fields",
    [
        {"robot": "1e308 0 0"},
        {"laser": "-1e7 0 0"},
        {"ranges": "1e400 1 1 1"},
        {"ranges": "nan 1 1 1"},
    ],
)
def test_a_line_of_impossible_numbers_is_skipped(fields: dict[str, str], tmp_path: Path) -> None:
    (tmp_path / "wild.log").write_text(log_of(**fields))
    log = read_carmen(tmp_path / "wild.log")
    assert len(log.scans) == 1
    assert log.skipped == {"broken lines": 1}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("FLASER " + "9" * 400 + " 1 2\n", r"no scan in it"),
        (log_of(time="1e300"), r"wild\.log:2: a time of 1e\+300 s after one of 1 s"),
        ("PARAM robot_front_laser_max nan\n" + log_of(), r"wild\.log:1: robot_front_laser_max must be a number"),
        ("PARAM robot_frontlaser_offset 1e9\n" + log_of(), r"wild\.log:1: robot_frontlaser_offset must be a number"),
    ],
)
def test_logs_that_cannot_be(text: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "wild.log").write_text(text)
    with pytest.raises(ConfigError, match=message):
        read_carmen(tmp_path / "wild.log")


EPISODES: dict[str, Any] = {
    "name": "some",
    "hardware": "3we_standard_v2",
    "seed": 1,
    "shortest": 2.0,
    "longest": 8.0,
    "straightness": 1.3,
    "episodes": {"office_v2": [[1, 2, [0.0, 0.0, 0.0], [2.0, 1.0], 2.3]]},
}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda e: e.pop("episodes"), "missing field 'episodes'"),
        (lambda e: e.update(episode={}), "unknown field 'episode'; did you mean 'episodes'"),
        (lambda e: e.update(episodes=[]), "episodes: expected lists of episodes, by scene"),
        (lambda e: e["episodes"].update(office_v2=None), "episodes: expected lists"),
        (lambda e: e["episodes"]["office_v2"].append(7), r"episodes\.office_v2\[1\]: expected \[index, seed"),
        (
            lambda e: e["episodes"]["office_v2"][0].__setitem__(1, 2**70),
            r"episodes\.office_v2\[0\] seed: expected",
        ),
        (
            lambda e: e["episodes"]["office_v2"][0].__setitem__(2, [0, 1]),
            r"episodes\.office_v2\[0\] start: expected",
        ),
        (
            lambda e: e["episodes"]["office_v2"][0].__setitem__(3, [0, 1e300]),
            r"episodes\.office_v2\[0\] goal: expected",
        ),
        (lambda e: e.update(seed="1"), "seed: expected a whole number"),
    ],
)
def test_episodes_that_cannot_be(change: Callable[[dict[str, Any]], object], message: str, tmp_path: Path) -> None:
    episodes = json.loads(json.dumps(EPISODES))
    change(episodes)
    path = tmp_path / "some.json"
    path.write_text(json.dumps(episodes))
    with pytest.raises(ConfigError, match=rf"some\.json: {message}"):
        load_episodes(path)


@pytest.mark.parametrize("content", [b"", b"[]", b"7", b"{", b"[" * 100_000, b"\xff\xfe", b'{"seed": NaN}'])
def test_files_that_hold_no_episodes(content: bytes, tmp_path: Path) -> None:
    (tmp_path / "some.json").write_bytes(content)
    with pytest.raises(ConfigError, match=r"some\.json:"):
        load_episodes(tmp_path / "some.json")


def test_relations_in_another_alphabet(tmp_path: Path) -> None:
    (tmp_path / "pairs").write_bytes(b"1 2 0 0 0 0 0 0\n\xff\xfe\n")
    with pytest.raises(ConfigError, match=r"pairs:2: expected UTF-8 text"):
        Relations.read(tmp_path / "pairs")


SCENE = """\
name: {name}
description: A hall
starts: [[0, 0, 0]]
walls: [{{a: [-3, -3], b: [3, -3]}}, {{a: [3, -3], b: [3, 3]}}, {{a: [3, 3], b: [-3, 3]}}, {{a: [-3, 3], b: [-3, -3]}}]
rooms: [{{name: {room}, min: [-3, -3], max: [3, 3], floor: wood, anchor: [0, 0]}}]
"""


@pytest.mark.parametrize("name", ['"../../etc/hall"', '"/tmp/hall"', '"..\\\\hall"', '".hall"', '"a\\u0001b"', '""'])
def test_names_that_no_file_and_no_format_takes(name: str) -> None:
    with pytest.raises(ConfigError, match=r"hall\.yaml:1: name: expected a name of at most 200 bytes"):
        threewe.Scene.parse(SCENE.format(name=name, room="hall"), "hall.yaml")
    with pytest.raises(ConfigError, match=r"hall\.yaml:5: rooms\[0\]\.name: expected a name"):
        threewe.Scene.parse(SCENE.format(name="hall", room=name), "hall.yaml")


def test_a_scene_is_not_written_under_such_a_name() -> None:
    with pytest.raises(ContractError, match="name: expected a name"):
        threewe.Scene.load("corridor_v1").to_yaml("../outside")


def test_descriptions_hold_no_control_characters() -> None:
    text = SCENE.format(name="hall", room="hall").replace("A hall", '"a\\u0000hall"')
    with pytest.raises(ConfigError, match=r"hall\.yaml:2: description: expected text without control characters"):
        threewe.Scene.parse(text, "hall.yaml")


CUT = 39 * "a" + "é/x"  # of which 40 bytes end in the middle of a character


def test_what_is_cut_short_in_a_message_stays_text() -> None:
    with pytest.raises(ConfigError, match=r"got 'a{39}'"):
        threewe.Scene.parse(SCENE.format(name=CUT, room="hall"), "hall.yaml")
    with pytest.raises(ConfigError, match=r"got 'a{39}'"):
        threewe.Scene.parse(SCENE.format(name="hall", room=CUT), "hall.yaml")
    with pytest.raises(ContractError, match=r"got 'a{39}'"):
        threewe.Scene.load("corridor_v1").to_yaml(CUT)


def read_map(path: Path) -> object:
    """The picture of a map stands in its seed, behind a line."""
    text, _, picture = path.read_bytes().partition(b"---8<---\n")
    path.write_bytes(text)
    (path.parent / "map.pgm").write_bytes(picture)
    return load_map(path)


NATIVE: dict[str, tuple[str, Callable[[Path], object]]] = {
    "scene": (".yaml", lambda path: threewe.Scene.load(str(path))),
    "profile": (".yaml", lambda path: threewe.RobotProfile.load(str(path))),
    "randomization": (".yaml", lambda path: _core.Randomization.load(str(path))),
    "map": (".yaml", read_map),
    "slam": (".slam", Slam.load),
    "places": (".yaml", lambda path: _core.load_places(str(path), None)),
}


@pytest.mark.parametrize("name", NATIVE)
def test_formats_read_in_cpp_raise_what_they_may_in_python_too(name: str, tmp_path: Path) -> None:
    suffix, read = NATIVE[name]
    path, draw = tmp_path / f"input{suffix}", random.Random(1)
    pool = [seed.read_bytes() for seed in sorted((CORPUS / name).iterdir())]
    pool += [mark + seed for mark in (b"\0\0\0\0", b"\xff\xfe") for seed in pool]  # other encodings
    for i in range(300):
        data = pool[i] if i < len(pool) else mutate(draw.choice(pool), pool, draw)
        path.write_bytes(data)
        with contextlib.suppress(ConfigError):
            read(path)


def test_bytes_of_a_map_that_are_no_text(tmp_path: Path) -> None:
    lines = (CORPUS / "slam/walk").read_bytes().splitlines(keepends=True)
    changed = [line.replace(b" ", b" \xd1", 1) if line.startswith(b"lidar") else line for line in lines]
    (tmp_path / "walk.slam").write_bytes(b"".join(changed))
    with pytest.raises(ConfigError, match=r"walk\.slam:\d+: base_from_lidar must be a finite number, got '\ufffd"):
        Slam.load(tmp_path / "walk.slam")
