"""Mapping on its own: logs, the mapper, relations, and the commands."""

from __future__ import annotations

import dataclasses
import json
import math
import re
import subprocess
import threading
from pathlib import Path

import command_line
import numpy as np
import pytest
import threewe
from numpy.typing import NDArray
from threewe.slam import (
    Log,
    Relations,
    Slam,
    SlamConfig,
    accuracy,
    load_map,
    log_names,
    read_carmen,
    read_log,
    relation_errors,
    replay,
    save_map,
    synthesize,
    write_carmen,
)
from threewe.slam.carmen import _fan
from threewe.slam.synth import record, true_relations

Array = NDArray[np.float64]

TOUR = """\
description: A small tour
scene: small.yaml
tour: [east, west, east]
"""
SCENE = """\
name: small
description: Two rooms
starts:
  - [0, 0, 0]
rooms:
  - {name: west, min: [-2, -2], max: [3, 2], floor: wood, anchor: [0, 0.5]}
  - {name: east, min: [3, -2], max: [8, 2], floor: wood, anchor: [6, -0.5]}
walls:
  - {a: [-2, -2], b: [8, -2]}
  - {a: [8, -2], b: [8, 2]}
  - {a: [8, 2], b: [-2, 2]}
  - {a: [-2, 2], b: [-2, -2]}
  - {a: [3, -2], b: [3, 2], doors: [{name: door, at: 2.2, width: 1.2}]}
objects:
  - {category: shelf, shape: bookcase, pose: [5.0, 1.7, -1.5708]}
"""


@pytest.fixture(scope="module")
def log_spec(tmp_path_factory: pytest.TempPathFactory) -> str:
    folder = tmp_path_factory.mktemp("log_spec")
    (folder / "small.yaml").write_text(SCENE)
    (folder / "tour.yaml").write_text(TOUR)
    return str(folder / "tour.yaml")


@pytest.fixture(scope="module")
def recorded(log_spec: str) -> tuple[Log, Array]:
    return record(log_spec, 3)


# logs


@pytest.mark.parametrize("count", [180, 181, 360, 361])
def test_what_is_written_is_read_again(count: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(count)
    angle_min, increment = _fan(count)
    log = Log(base_from_lidar=threewe.Pose2D(0.1, -0.02, 0.05))
    for i in range(20):
        ranges = rng.uniform(0.0, 90.0, count).clip(max=80.0).astype(np.float32)
        pose = threewe.Pose2D(*rng.uniform(-9, 9, 2), rng.uniform(-3, 3))
        log.add(976052857.25 + 0.5 * i, threewe.LaserScan(ranges, angle_min, increment, 0.0, 80.0), pose)
    write_carmen(tmp_path / "a.log", log)
    again = read_log(tmp_path / "a.log")
    assert again.times == log.times
    assert again.skipped == {}
    assert list(again.base_from_lidar) == pytest.approx(list(log.base_from_lidar), abs=1e-5)
    for ours, theirs in zip(log.scans, again.scans, strict=True):
        assert np.abs(ours.ranges - theirs.ranges).max() < 0.00501
        assert (theirs.angle_min, theirs.angle_increment) == (angle_min, increment)
    for before, after in zip(log.odometry, again.odometry, strict=True):
        assert list(before) == pytest.approx(list(after), abs=1e-5)


def test_a_log_in_the_newer_form(tmp_path: Path) -> None:
    head = "ROBOTLASER1 0 -1.570796 3.141593 0.785398 8.0 0.01 0"
    tail = "1.2 2.0 0.1 1.0 2.0 0.1 0 0 0 0 0"
    text = f"# CARMEN Logfile\n{head} 5 1 2 3 9 5 2 7 7 {tail} 12.5 nohost 0.1\n"
    text += "FLASER 2 1 1 0 0 0 0 0 0 12.6 nohost 0.1\n"  # the same scan in the older form
    text += f"{head} 5 1 2 3 4 5 0 {tail} 12.5 nohost 0.1\n"  # the same time again
    text += f"{head} 5 1 2 3 4 5 0 {tail} 13.5 nohost 0.2\n"
    (tmp_path / "new.log").write_text(text)
    log = read_carmen(tmp_path / "new.log")
    assert log.times == [12.5, 13.5]
    assert log.skipped == {"scans no later than the one before": 1}
    assert log.scans[0].ranges.tolist() == [1, 2, 3, 8, 5]
    assert log.scans[0].angle_min == pytest.approx(-math.pi / 2, abs=1e-6)
    assert list(log.odometry[0]) == [1.0, 2.0, 0.1]
    # in the robot's frame, which is turned by 0.1
    assert list(log.base_from_lidar) == pytest.approx([0.2 * math.cos(0.1), -0.2 * math.sin(0.1), 0.0])


def test_broken_lines_are_counted(recorded: tuple[Log, Array], tmp_path: Path) -> None:
    write_carmen(tmp_path / "good.log", recorded[0])
    lines = (tmp_path / "good.log").read_text().splitlines()
    scans = [i for i, line in enumerate(lines) if line.startswith("FLASER")]
    lines[scans[3]] = lines[scans[3]][:200]  # cut short
    lines[scans[5]] = lines[scans[5]].replace(" nohost", "", 1).replace("FLASER 180", "FLASER x")
    lines[scans[7]] = "FLASER 180 nan" + lines[scans[7]][14:]
    (tmp_path / "bad.log").write_text("\n".join(lines))
    log = read_carmen(tmp_path / "bad.log")
    assert log.skipped == {"broken lines": 3}
    assert len(log.scans) == len(recorded[0].scans) - 3


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", ":1: no scan in it; a CARMEN log has lines that begin with FLASER or ROBOTLASER1"),
        (
            "FLASER 2 1 1 0 0 0 0 0 0 1 h 1\nODOM\nFLASER 3 1 1 1 0 0 0 0 0 0 2 h 1\n",
            ":3: a scan of 3 ranges after scans of 2",
        ),
    ],
)
def test_what_is_no_log_is_one_error(text: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "x.log").write_text(text)
    with pytest.raises(threewe.ConfigError, match="^" + str(tmp_path / "x.log") + message + "$"):
        read_carmen(tmp_path / "x.log")


def test_a_corrected_log_has_no_laser_that_flies_around(tmp_path: Path) -> None:
    text = "".join(f"FLASER 2 1 1 {i} {0.1 * i} 0 {i} 0 0 {i + 1} h 1\n" for i in range(5))
    (tmp_path / "corrected.log").write_text(text)
    assert list(read_carmen(tmp_path / "corrected.log").base_from_lidar) == [0, 0, 0]


def stamped(log: Log, stamps: list[float], logged: list[float], path: Path) -> Path:
    """The log with other stamps."""
    write_carmen(path, log)
    lines = path.read_text().splitlines()
    scans = [i for i, line in enumerate(lines) if line.startswith("FLASER")]
    for i, ipc, logger in zip(scans, stamps, logged, strict=True):
        lines[i] = " ".join([*lines[i].split()[:-3], f"{ipc:.6f}", "nohost", f"{logger:.6f}"])
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize("kind", ["equal", "backward", "set back", "whole seconds"])
def test_scans_whose_stamps_do_not_advance_are_numbered(kind: str, recorded: tuple[Log, Array], tmp_path: Path) -> None:
    log, truth = recorded
    times = np.array(log.times)
    stamps = {
        "equal": np.zeros(len(times)),
        "backward": 1e9 - times,
        "set back": np.where(times < 10.0, times + 3600.0, times),
        "whole seconds": np.floor(times / 5.0) * 5.0,
    }[kind].tolist()

    # the logger's own stamps advance
    read = read_carmen(stamped(log, stamps, log.times, tmp_path / "logger.log"))
    assert read.times == pytest.approx(log.times, abs=1e-5)
    assert re.fullmatch(
        r".*logger\.log:\d+: \d+ of \d+ stamps are no later than .*: times are the logger's", read.clock
    )

    # nothing does
    path = stamped(log, stamps, stamps, tmp_path / "none.log")
    read = read_carmen(path)
    assert len(read.scans) == len(log.scans)
    assert read.skipped == {}
    assert read.times == pytest.approx(0.2 * np.arange(len(log.scans)))
    assert read.clock.startswith(f"{path}:")
    assert read.clock.endswith("scans are numbered, 0.2 s apart")
    result = replay(read)
    np.testing.assert_allclose(result.trajectory[:, 1:3], truth[:, 1:3], atol=0.08)
    assert result.summary()["clock"] == read.clock
    with pytest.raises(threewe.ConfigError, match=r"none\.log:\d+: .* relations refer to stamps"):
        result.accuracy(true_relations(truth))


def test_a_few_stamps_that_do_not_advance_are_skipped(recorded: tuple[Log, Array], tmp_path: Path) -> None:
    log, _ = recorded
    stamps = list(log.times)
    stamps[7] = stamps[6]
    read = read_carmen(stamped(log, stamps, stamps, tmp_path / "few.log"))
    assert (read.clock, read.skipped) == ("", {"scans no later than the one before": 1})


# relations


def matrix(x: float, y: float, theta: float) -> Array:
    c, s = math.cos(theta), math.sin(theta)
    return np.array([[c, -s, x], [s, c, y], [0, 0, 1]])


def test_the_error_is_that_of_matrices() -> None:
    for seed in range(200):
        rng = np.random.default_rng(seed)
        trajectory = np.c_[np.arange(30.0), rng.uniform(-9, 9, (30, 2)), rng.uniform(-3.1, 3.1, 30)]
        times = rng.integers(0, 30, (50, 2)).astype(float)
        known = np.c_[rng.uniform(-5, 5, (50, 2)), rng.uniform(-3.1, 3.1, 50)]
        translation, rotation, left_out = relation_errors(trajectory, Relations(times, known))
        assert left_out == 0
        for i in range(50):
            a, b = (matrix(*trajectory[int(t), 1:]) for t in times[i])
            off = np.linalg.inv(matrix(*known[i])) @ np.linalg.inv(a) @ b
            assert translation[i] == pytest.approx(math.hypot(off[0, 2], off[1, 2])), f"seed {seed}"
            assert rotation[i] == pytest.approx(abs(math.atan2(off[1, 0], off[0, 0]))), f"seed {seed}"


def test_the_figures_are_means_and_deviations() -> None:
    trajectory = np.array([[0.0, 0, 0, 0], [1.0, 1, 0, 0], [2.0, 2, 0, 0.1]])
    relations = Relations(
        np.array([[0.0, 1.0], [1.05, 2.0], [0, 9]]), np.array([[1.0, 0.3, 0], [1.0, 0.1, 0], [0, 0, 0]])
    )
    result = accuracy(trajectory, relations)
    assert (result.relations, result.left_out) == (2, 1)
    assert result.translation == pytest.approx((0.2, 0.1))
    assert result.squared_translation == pytest.approx((0.05, 0.04))
    assert result.rotation == pytest.approx((math.degrees(0.05), math.degrees(0.05)))
    with pytest.raises(threewe.ConfigError, match=r"no relation is within the trajectory: times from 5\.000 to 9\.000"):
        accuracy(trajectory, Relations(np.array([[5.0, 9.0]]), np.zeros((1, 3))))


def test_between_scans_the_trajectory_is_interpolated() -> None:
    trajectory = np.array([[0.0, 0, 0, 3.0], [1.0, 2.0, 0, -3.0]])
    relations = Relations(np.array([[0.0, 0.5]]), np.array([[-1.0 * math.cos(3.0), 0, 0]]))
    _, rotation, _ = relation_errors(trajectory, relations)
    assert rotation[0] == pytest.approx(math.pi - 3.0)


def test_relations_are_read_again(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    relations = Relations(rng.uniform(0, 99, (30, 2)).round(6), rng.uniform(-3, 3, (30, 3)).round(6))
    relations.write(tmp_path / "a.relations")
    again = Relations.read(tmp_path / "a.relations")
    np.testing.assert_allclose(again.times, relations.times)
    np.testing.assert_allclose(again.poses, relations.poses)
    (tmp_path / "b.relations").write_text("# pairs\n1 2 0 0 0 0 0 0\n\n1 2 0 0 0\n")
    with pytest.raises(threewe.ConfigError, match=r"b\.relations:4: a relation is eight numbers"):
        Relations.read(tmp_path / "b.relations")


def test_true_relations_have_no_error(recorded: tuple[Log, Array]) -> None:
    _, truth = recorded
    relations = true_relations(truth)
    translation, rotation, left_out = relation_errors(truth, relations)
    assert (translation.max(), rotation.max(), left_out) == pytest.approx((0, 0, 0), abs=1e-9)
    apart = np.abs(np.diff(relations.times, axis=1))
    assert (apart > 20.0).any()  # places met again
    assert np.linalg.norm(relations.poses[:, :2], axis=1).max() < 1.6


# the mapper


def test_a_map_from_a_log(recorded: tuple[Log, Array], tmp_path: Path) -> None:
    log, truth = recorded
    result = replay(log)
    assert result.trajectory.shape == truth.shape
    np.testing.assert_allclose(result.trajectory[:, :3], truth[:, :3], atol=0.08)
    relations = true_relations(truth)
    ours = accuracy(result.trajectory, relations)
    reckoned = np.c_[log.times, [tuple(pose) for pose in log.odometry]]
    assert ours.translation[0] < 0.03 < accuracy(reckoned, relations).translation[0]
    result.write(tmp_path, ours)
    assert json.loads((tmp_path / "summary.json").read_text())["accuracy"]["relations"] == ours.relations
    words = (tmp_path / "trajectory.tum").read_text().splitlines()[-1].split()
    assert float(words[0]) == pytest.approx(log.times[-1], abs=1e-6)
    assert 2 * math.atan2(float(words[6]), float(words[7])) == pytest.approx(result.trajectory[-1, 3], abs=1e-6)


def test_a_map_is_saved_as_ros_has_it(tmp_path: Path) -> None:
    cells = np.array([[-1, 0, 100], [25, 26, 65]], dtype=np.int8)
    save_map(threewe.OccupancyGrid(cells, 0.1, (-1.0, 2.5)), tmp_path / "map.yaml")
    assert (tmp_path / "map.pgm").read_bytes().endswith(b"\n3 2\n255\n" + bytes([254, 205, 0, 205, 254, 0]))
    text = (tmp_path / "map.yaml").read_text()
    assert "resolution: 0.1\norigin: [-1, 2.5, 0]\n" in text
    again = load_map(tmp_path / "map.yaml")
    assert again.data.tolist() == [[-1, 0, 100], [0, -1, 100]]
    assert (again.resolution, again.origin) == (0.1, (-1.0, 2.5))


def test_places_are_recognised_where_the_robot_comes_back(log_spec: str) -> None:
    longer = Path(log_spec).with_name("longer.yaml")
    longer.write_text(TOUR + "laps: 3\n")
    log, truth = record(str(longer), 4)
    result = replay(log)
    closures = result.closures
    assert len(closures.times) == result.summary()["loop_closures"] >= 2
    assert (closures.times[:, 1] - closures.times[:, 0] > 10.0).all()
    translation, rotation, left_out = relation_errors(truth, closures)
    assert left_out == 0
    assert translation.max() < 0.1
    assert rotation.max() < np.radians(2.0)


def test_a_map_is_kept_and_continued(recorded: tuple[Log, Array], tmp_path: Path) -> None:
    log, truth = recorded
    half = len(log.scans) // 2
    slam = Slam(SlamConfig(base_from_lidar=log.base_from_lidar))
    for time, scan, odometry in zip(log.times[:half], log.scans, log.odometry, strict=False):
        slam.add(scan, odometry, time)
    slam.save(tmp_path / "half.slam")
    again = Slam.load(str(tmp_path / "half.slam"))
    assert np.array_equal(again.map().data, slam.map().data)
    assert np.array_equal(again.trajectory(), slam.trajectory())
    assert np.array_equal(again.closures().poses, slam.closures().poses)

    # on another day odometry begins anew, and the robot is not quite where it is said to be
    pose = slam.trajectory()[-1, 1:] + np.array([0.3, -0.2, 0.1])
    day = Slam.load(tmp_path / "half.slam", pose=pose)
    for time, scan, odometry in zip(
        log.times[half - 1 :], log.scans[half - 1 :], log.odometry[half - 1 :], strict=True
    ):
        day.add(scan, odometry, time + 1000.0)
    assert len(day.trajectory()) == len(truth) + 1
    np.testing.assert_allclose(day.trajectory()[half:, 1:3], truth[half - 1 :, 1:3], atol=0.1)
    with pytest.raises(threewe.ContractError, match="time must go on"):
        again.add(log.scans[0], (0, 0, 0), log.times[0])


def test_files_that_are_no_maps(recorded: tuple[Log, Array], tmp_path: Path) -> None:
    log, _ = recorded
    slam = Slam()
    with pytest.raises(threewe.ContractError, match="a map without any scan cannot be saved"):
        slam.save(tmp_path / "empty.slam")
    slam.add(log.scans[0], (0, 0, 0))
    with pytest.raises(threewe.ConfigError, match=r"nowhere/a\.slam: the map cannot be written there"):
        slam.save(tmp_path / "nowhere/a.slam")
    with pytest.raises(threewe.ConfigError, match=r"none\.slam: cannot be read"):
        Slam.load(tmp_path / "none.slam")
    slam.save(tmp_path / "a.slam")
    text = (tmp_path / "a.slam").read_text()
    (tmp_path / "cut.slam").write_text(text[: len(text) // 2])
    with pytest.raises(threewe.ConfigError, match=r"cut\.slam:\d+: "):
        Slam.load(tmp_path / "cut.slam")
    with pytest.raises(threewe.ContractError, match="pose must"):
        Slam.load(tmp_path / "a.slam", pose=(1.0, math.nan, 0.0))
    assert [path.name for path in sorted(tmp_path.iterdir())] == ["a.slam", "cut.slam"]


def test_wrong_input_is_one_error(recorded: tuple[Log, Array]) -> None:
    log, _ = recorded
    slam = Slam(SlamConfig(base_from_lidar=log.base_from_lidar))
    assert slam.add(log.scans[0], (1.0, 2.0, 0.3)) == threewe.Pose2D()
    for arguments, message in [
        ((log.scans[0], (math.nan, 0, 0)), "odometry must be finite"),
        ((log.scans[0].ranges, (0, 0, 0)), "scan must be a LaserScan"),
        ((log.scans[0], (0, 0, 0), 0.0), r"time must go on from scan to scan: 0\.000000 s after 0\.000000 s"),
        ((log.scans[0], (0, 0, 0), -1.0), "time must lie in"),
        ((log.scans[0], "here"), "odometry must hold numbers"),
    ]:
        with pytest.raises(threewe.ContractError, match=message):
            slam.add(*arguments)  # type: ignore[arg-type]
    assert slam.trajectory().tolist() == [[0, 0, 0, 0]]
    with pytest.raises(threewe.ContractError, match=r"range_max must lie in \[1, 200\] m, got 0"):
        Slam(SlamConfig(range_max=0.0))


def test_what_is_wrong_with_the_input_is_told(recorded: tuple[Log, Array], caplog: pytest.LogCaptureFixture) -> None:
    log, truth = recorded
    assert replay(log).events == []
    assert caplog.records == []

    reset = len(log.scans) // 2
    there = log.odometry[reset].inverse()
    odometry = [pose if i < reset else there * pose for i, pose in enumerate(log.odometry)]
    result = replay(dataclasses.replace(log, odometry=odometry))
    assert [event.incident for event in result.events] == ["odometry_jumped"]
    assert result.events[0].begin == pytest.approx(log.times[reset] - log.times[0], abs=1e-6)
    assert "odometry_jumped: scans contradict a step of the odometry" in caplog.text
    np.testing.assert_allclose(result.trajectory[:, 1:3], truth[:, 1:3], atol=0.1)

    scans = [log.scans[reset] if reset < i < reset + 8 else scan for i, scan in enumerate(log.scans)]
    events = replay(dataclasses.replace(log, scans=scans)).events
    assert "lidar_frozen" in [event.incident for event in events]


def test_scans_that_overlap_need_no_odometry() -> None:
    slam = Slam()
    for i in range(60):
        x = 0.02 * i  # ahead, from one end of a room to the other
        angles = np.linspace(-np.pi, np.pi, 360, endpoint=False)
        with np.errstate(divide="ignore"):
            walls = [
                (4.0 - x) / np.cos(angles),
                (-1.0 - x) / np.cos(angles),
                2.0 / np.sin(angles),
                -1.5 / np.sin(angles),
            ]
        ranges = np.min([np.where(wall > 0.0, wall, np.inf) for wall in walls], axis=0).astype(np.float32)
        pose = slam.add(threewe.LaserScan(ranges, -np.pi, np.pi / 180, range_min=0.0, range_max=30.0), None, 0.1 * i)
    assert list(pose) == pytest.approx([1.18, 0.0, 0.0], abs=0.03)
    assert slam.events() == []


def test_a_second_thread_is_refused(recorded: tuple[Log, Array]) -> None:
    log, _ = recorded
    slam = Slam()
    refused: list[str] = []
    done = threading.Event()

    def look() -> None:
        while not done.is_set():
            for call in (slam.map, slam.trajectory, slam.events, slam.closures, slam.components):
                try:
                    call()
                except threewe.ContractError as error:
                    refused.append(str(error))

    other = threading.Thread(target=look)
    other.start()
    added = 0
    for time, scan, odometry in zip(log.times, log.scans, log.odometry, strict=True):
        try:
            slam.add(scan, odometry, time)
            added += 1
        except threewe.ContractError as error:
            refused.append(str(error))
    done.set()
    other.join()
    assert refused
    assert set(refused) == {
        "a Slam is in use on another thread, and one thread at a time may use it: wait for that call, or guard the "
        "Slam with a lock of your own"
    }
    assert len(slam.trajectory()) == added


# the commands


def run(*arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    return command_line.threewe("slam", *arguments, cwd=cwd)


def test_synth_and_replay(log_spec: str, tmp_path: Path) -> None:
    assert run("synth", log_spec, "-o", "logs", "--seed", "3", cwd=tmp_path).returncode == 0
    done = run("replay", "logs/tour.log", "--relations", "logs/tour.relations", "-o", "out", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    summary = json.loads((tmp_path / "out/summary.json").read_text())
    assert summary["accuracy"]["translation"][0] < 0.03
    assert summary["beams"] == 180
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        "map.pgm",
        "map.yaml",
        "trajectory.tum",
        "summary.json",
    }


def test_a_robot_that_was_carried_away_is_reported(recorded: tuple[Log, Array], tmp_path: Path) -> None:
    log, truth = recorded
    rng = np.random.default_rng(1)
    scans, odometry = list(log.scans), list(log.odometry)
    for i in range(12):  # in a place of its own, whose walls are where no walls were
        x = 0.3 * i
        angles = log.scans[0].angle_min + log.scans[0].angle_increment * np.arange(180)
        walls = [(9.0 - x) / np.maximum(np.cos(angles), 1e-9), 0.6 / np.maximum(np.abs(np.sin(angles)), 1e-9)]
        ranges = np.min(walls, axis=0) + rng.normal(0.0, 0.01, 180)
        scans.append(threewe.LaserScan(ranges.astype(np.float32), angles[0], log.scans[0].angle_increment, 0.0, 80.0))
        odometry.append(log.odometry[-1] * threewe.Pose2D(x, 0.0, 0.0))
    times = [*log.times, *(log.times[-1] + 1.0 + np.arange(12.0))]
    write_carmen(tmp_path / "carried.log", Log(times, scans, odometry, log.base_from_lidar))
    true_relations(truth).write(tmp_path / "carried.relations")
    done = run("replay", "carried.log", "--relations", "carried.relations", "-o", "out", cwd=tmp_path)
    assert done.returncode == 1
    assert "track_lost" in done.stdout
    summary = json.loads((tmp_path / "out/summary.json").read_text())
    assert [event["incident"] for event in summary["events"]] == ["track_lost"]
    assert 8 <= summary["scans_outside_map"] <= 12
    assert summary["accuracy"]["translation"][0] < 0.03


def test_a_seed_names_a_log_to_the_byte(log_spec: str, tmp_path: Path) -> None:
    texts = []
    for folder, seed in [("a", 1), ("b", 1), ("c", 2)]:
        log, relations = synthesize(log_spec, tmp_path / folder, seed)
        texts.append((log.read_bytes(), relations.read_bytes()))
    assert texts[0] == texts[1]
    assert texts[0][0] != texts[2][0]
    assert texts[0][1] == texts[2][1]  # the same drive


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["replay", "none.log"], "error: none.log: no such log"),
        (["replay", "empty.log"], "error: empty.log:1: no scan in it"),
        (["synth", "labratory"], "unknown log 'labratory'; did you mean 'laboratory'?"),
    ],
)
def test_mistakes_are_one_line(arguments: list[str], message: str, tmp_path: Path) -> None:
    (tmp_path / "empty.log").write_text("# CARMEN Logfile\n")
    done = run(*arguments, cwd=tmp_path)
    assert done.returncode == 2
    assert message in " ".join(done.stderr.split())
    assert "Traceback" not in done.stderr


def test_the_four_log_specifications_can_be_read() -> None:
    assert set(log_names()) == {"laboratory", "office_loop", "long_corridor", "campus_loop"}
    for name in log_names():
        assert len(threewe.slam.LogSpec.load(name).stops) > 3
