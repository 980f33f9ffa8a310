"""rosbag2 recordings are read as what they are."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import command_line
import numpy as np
import pytest
import threewe
from threewe.slam import read_log

pytest.importorskip("rosbags", reason="not shown: needs rosbags")
from rosbags.rosbag2 import Writer
from rosbags.typesys import Stores, get_typestore

STORE = get_typestore(Stores.ROS2_HUMBLE)
START = 1_700_000_000  # [s]


def make(kind: str, **fields: Any) -> Any:
    return STORE.types[kind](**fields)


def header(time: float, frame: str) -> Any:
    nanoseconds = round(time * 1e9)
    stamp = make("builtin_interfaces/msg/Time", sec=START + nanoseconds // 10**9, nanosec=nanoseconds % 10**9)
    return make("std_msgs/msg/Header", stamp=stamp, frame_id=frame)


def turned(yaw: float) -> Any:
    return make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=math.sin(yaw / 2), w=math.cos(yaw / 2))


def odometry(time: float, pose: threewe.Pose2D) -> Any:
    nothing = make("geometry_msgs/msg/Vector3", x=0.0, y=0.0, z=0.0)
    place = make("geometry_msgs/msg/Point", x=pose.x, y=pose.y, z=0.0)
    where = make("geometry_msgs/msg/Pose", position=place, orientation=turned(pose.theta))
    speed = make("geometry_msgs/msg/Twist", linear=nothing, angular=nothing)
    return make(
        "nav_msgs/msg/Odometry",
        header=header(time, "odom"),
        child_frame_id="base_footprint",
        pose=make("geometry_msgs/msg/PoseWithCovariance", pose=where, covariance=np.zeros(36)),
        twist=make("geometry_msgs/msg/TwistWithCovariance", twist=speed, covariance=np.zeros(36)),
    )


def scan(time: float, ranges: list[float], first: float, increment: float) -> Any:
    return make(
        "sensor_msgs/msg/LaserScan",
        header=header(time, "laser"),
        angle_min=first,
        angle_max=first + increment * (len(ranges) - 1),
        angle_increment=increment,
        time_increment=0.001,
        scan_time=0.1,
        range_min=0.1,
        range_max=12.0,
        ranges=np.array(ranges, dtype=np.float32),
        intensities=np.array([], dtype=np.float32),
    )


def transform(parent: str, child: str, x: float, y: float, yaw: float) -> Any:
    shift = make("geometry_msgs/msg/Vector3", x=x, y=y, z=0.2)
    return make(
        "geometry_msgs/msg/TransformStamped",
        header=header(0.0, parent),
        child_frame_id=child,
        transform=make("geometry_msgs/msg/Transform", translation=shift, rotation=turned(yaw)),
    )


def write(path: Path, topics: dict[str, list[tuple[float, Any]]]) -> Path:
    with Writer(path, version=9) as writer:
        for topic, messages in topics.items():
            kind = messages[0][1].__msgtype__
            connection = writer.add_connection(topic, kind, typestore=STORE)
            for time, message in messages:
                writer.write(connection, START * 10**9 + round(time * 1e9), STORE.serialize_cdr(message, kind))
    return path


def recording(path: Path, increment: float = 0.01) -> Path:
    """A robot on an arc: 20 Hz odometry, 4 scans, one of them before the first odometry."""
    poses = [(0.05 * i, threewe.Pose2D(0.02 * i, 0.5, 3.0 + 0.01 * i)) for i in range(2, 60)]
    ranges = [0.05, 1.0, math.inf, math.nan, 3.0]
    scans = [(t, scan(t, ranges, -0.02 if increment > 0 else 0.02, increment)) for t in (0.0, 0.575, 1.0, 2.0)]
    fixed = [transform("base_footprint", "base", 0.0, 0.0, 0.0), transform("base", "mast", 0.1, 0.2, math.pi / 2)]
    fixed.append(transform("mast", "laser", 0.3, 0.0, 0.0))
    return write(
        path,
        {
            "/odom": [(t, odometry(t, pose)) for t, pose in poses],
            "/scan": scans,
            "/tf_static": [(0.0, make("tf2_msgs/msg/TFMessage", transforms=fixed))],
        },
    )


def test_a_recording_is_a_log(tmp_path: Path) -> None:
    log = read_log(recording(tmp_path / "bag"))
    assert [time - START for time in log.times] == pytest.approx([0.575, 1.0, 2.0])
    assert log.skipped == {"scans without odometry around them": 1}
    assert list(log.base_from_lidar) == pytest.approx([0.1, 0.5, math.pi / 2])
    assert list(log.odometry[0]) == pytest.approx([0.23, 0.5, 3.115])
    assert list(log.odometry[2]) == pytest.approx([0.8, 0.5, 3.4 - 2 * math.pi])
    assert log.scans[0].ranges.tolist() == [0, 1, 12, 0, 3]  # too near, a wall, nothing, invalid, a wall
    assert log.scans[0].time_increment == pytest.approx(0.001)
    assert log.scans[0].range_min == pytest.approx(0.1)


def test_a_clockwise_lidar_is_turned_round(tmp_path: Path) -> None:
    scan = read_log(recording(tmp_path / "bag", increment=-0.01)).scans[0]
    assert scan.ranges.tolist() == [3, 0, 12, 1, 0]
    assert (scan.angle_min, scan.angle_increment) == pytest.approx((-0.02, 0.01))
    assert scan.time_increment == pytest.approx(-0.001)


def test_what_is_missing_is_told(tmp_path: Path) -> None:
    bag = write(tmp_path / "bag", {"/odom": [(0.0, odometry(0.0, threewe.Pose2D()))]})
    with pytest.raises(threewe.ConfigError, match=r"no sensor_msgs/msg/LaserScan in it; topics: /odom"):
        read_log(bag)
    (tmp_path / "empty").mkdir()
    for name in ("garbage.db3", "garbage.mcap"):
        (tmp_path / name).write_text("no recording at all")
    for name in ("empty", "garbage.db3", "garbage.mcap"):
        with pytest.raises(threewe.ConfigError, match=rf"{name}: not a rosbag2 that can be read"):
            read_log(tmp_path / name)
    with pytest.raises(threewe.ConfigError, match=r"nothing\.mcap: no such file"):
        read_log(tmp_path / "nothing.mcap")


def test_transforms_in_a_ring_end(tmp_path: Path) -> None:
    poses = [(0.05 * i, threewe.Pose2D(0.02 * i, 0.0, 0.0)) for i in range(60)]
    ring = [transform(a, b, 1.0, 0.0, 0.0) for a, b in ("ab", "bc", "ca")]
    base = [transform("a", "base_footprint", 0.0, 0.0, 0.0), transform("a", "a", 0.0, 0.0, 0.0)]
    for name, fixed in (("ring", ring + base), ("none", ring)):
        bag = write(
            tmp_path / name,
            {
                "/odom": [(t, odometry(t, pose)) for t, pose in poses],
                "/scan": [(1.0, scan(1.0, [1.0, 2.0], 0.0, 0.1))],
                "/tf_static": [(0.0, make("tf2_msgs/msg/TFMessage", transforms=fixed))],
            },
        )
        assert read_log(bag).base_from_lidar == threewe.Pose2D()


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("angle_min", 1e30),
        ("angle_increment", 1e9),
        ("angle_increment", 0.0),
        ("range_max", math.inf),
        ("time_increment", 1e9),
    ],
)
def test_a_scan_that_no_lidar_makes_is_named(field: str, value: float, tmp_path: Path) -> None:
    wild = scan(1.0, [1.0, 2.0, 3.0], 0.0, 0.1)
    object.__setattr__(wild, field, value)
    bag = write(
        tmp_path / "bag",
        {"/odom": [(0.1 * i, odometry(0.1 * i, threewe.Pose2D())) for i in range(20)], "/scan": [(1.0, wild)]},
    )
    with pytest.raises(threewe.ConfigError, match=r"bag: scan 1: a scan"):
        read_log(bag)


@pytest.mark.parametrize("far", [1e7, 1e200, math.inf, math.nan])
def test_odometry_that_no_map_holds_is_named(far: float, tmp_path: Path) -> None:
    bag = write(
        tmp_path / "bag",
        {
            "/odom": [(0.1 * i, odometry(0.1 * i, threewe.Pose2D(far, 0.0, 0.0))) for i in range(20)],
            "/scan": [(1.0, scan(1.0, [1.0, 2.0, 3.0], 0.0, 0.1))],
        },
    )
    with pytest.raises(threewe.ConfigError, match=r"bag: (scan 1: odometry|message 1 of /odom: a pose) must be finite"):
        read_log(bag)


def test_bytes_that_were_cut_off_are_named(tmp_path: Path) -> None:
    recording(tmp_path / "bag")
    metadata = tmp_path / "bag/metadata.yaml"
    good = metadata.read_text()
    for bad in ("", "7", "rosbag2_bagfile_information: []", "[" * 5000, good.replace("version: 9", "version: x")):
        metadata.write_text(bad)
        with pytest.raises(threewe.ConfigError, match=r"bag: "):
            read_log(tmp_path / "bag")
    metadata.write_text(good)
    database = next((tmp_path / "bag").glob("*.db3"))
    content = bytearray(database.read_bytes())
    for at in range(5000, len(content), 97):
        content[at] ^= 0xFF
    database.write_bytes(content)
    with pytest.raises(threewe.ConfigError, match=r"bag: "):
        read_log(tmp_path / "bag")


def test_the_command_maps_it(tmp_path: Path) -> None:
    recording(tmp_path / "bag")
    done = command_line.threewe("slam", "replay", "bag", "-o", "out", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out/map.pgm").exists()
