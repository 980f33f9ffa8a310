"""rosbag2 recordings: the scans of one lidar, the odometry around each of them, and where the lidar is on the robot."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.highlevel import AnyReader, AnyReaderError
from rosbags.rosbag2 import ReaderError
from rosbags.typesys import Stores, get_typestore

from threewe._core import LaserScan, Pose2D
from threewe.errors import ConfigError
from threewe.slam.log import Log, Progress

SCAN, ODOMETRY, TRANSFORMS = "sensor_msgs/msg/LaserScan", "nav_msgs/msg/Odometry", "tf2_msgs/msg/TFMessage"


def read_rosbag(path: Path, *, on_progress: Progress | None = None) -> Log:
    """Reads the topic of type LaserScan and the one of type Odometry; where there are several, that with most messages.
    Scans before the first or after the last odometry are skipped and counted. Raises ConfigError.
    """
    try:
        with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
            return _read(path, reader, on_progress)
    except (AnyReaderError, ReaderError, FileNotFoundError) as error:
        raise ConfigError(f"{path}: not a rosbag2 that can be read: {error}") from None


def _read(path: Path, reader: AnyReader, on_progress: Progress | None) -> Log:
    wanted = [_busiest(path, reader, kind) for kind in (SCAN, ODOMETRY)]
    wanted += [c for c in reader.connections if c.msgtype == TRANSFORMS and c.topic.endswith("tf_static")]
    scans: list[Any] = []
    odometry: list[Any] = []
    transforms: dict[str, tuple[str, Pose2D]] = {}
    for connection, stamp, data in reader.messages(wanted):
        message: Any = reader.deserialize(data, connection.msgtype)
        if connection.msgtype == TRANSFORMS:
            for t in message.transforms:
                transforms[t.child_frame_id] = t.header.frame_id, _pose(t.transform.translation, t.transform.rotation)
        else:
            (scans if connection.msgtype == SCAN else odometry).append(message)
        if on_progress:
            on_progress((stamp - reader.start_time) / max(reader.duration, 1))
    return _log(scans, odometry, transforms)


def _busiest(path: Path, reader: AnyReader, kind: str) -> Any:
    found = [connection for connection in reader.connections if connection.msgtype == kind and connection.msgcount]
    if not found:
        raise ConfigError(f"{path}: no {kind} in it; topics: {', '.join(sorted(reader.topics)) or 'none'}")
    return max(found, key=lambda connection: connection.msgcount)


def _log(scans: Sequence[Any], odometry: Sequence[Any], transforms: dict[str, tuple[str, Pose2D]]) -> Log:
    log = Log(base_from_lidar=_mount(odometry[0].child_frame_id, scans[0].header.frame_id, transforms))
    times = np.array([_time(message) for message in odometry])
    poses = [_pose(message.pose.pose.position, message.pose.pose.orientation) for message in odometry]
    x, y = ([getattr(pose, axis) for pose in poses] for axis in "xy")
    theta = np.unwrap([pose.theta for pose in poses])
    for message in scans:
        time = _time(message)
        if not times[0] <= time <= times[-1]:
            log.skip("scans without odometry around them")
            continue
        log.add(time, _scan(message), Pose2D(*(float(np.interp(time, times, values)) for values in (x, y, theta))))
    if not log.scans:
        raise ConfigError("no scan lies between the first and the last odometry: are these stamps of one clock?")
    return log


def _scan(message: Any) -> LaserScan:
    """ROS marks what did not return as infinite or beyond the maximum, and what is invalid as NaN or too near."""
    ranges = np.asarray(message.ranges, dtype=np.float32)
    ranges = np.where(np.isnan(ranges) | (ranges < message.range_min), np.float32(0.0), ranges)
    ranges = np.minimum(ranges, np.float32(message.range_max))
    first, increment, sweep = message.angle_min, message.angle_increment, message.time_increment
    if increment < 0.0:  # clockwise: the last beam is the first of a scan that goes the other way
        first, increment, sweep, ranges = first + (len(ranges) - 1) * increment, -increment, -sweep, ranges[::-1]
    return LaserScan(np.ascontiguousarray(ranges), first, increment, message.range_min, message.range_max, sweep)


def _mount(base: str, lidar: str, transforms: dict[str, tuple[str, Pose2D]]) -> Pose2D:
    """base_from_lidar, up the tree of fixed transforms; none where the recording has no such tree."""
    base_from_lidar, frame = Pose2D(), lidar
    chains: dict[str, Pose2D] = {frame: base_from_lidar}
    while frame in transforms and frame != base:
        frame, parent_from_frame = transforms[frame]
        base_from_lidar = parent_from_frame * base_from_lidar
        if frame in chains:
            break
        chains[frame] = base_from_lidar
    if frame == base:
        return base_from_lidar
    # the odometer's frame may hang below what both share, as base_footprint does
    ancestor, ancestor_from_base = base, Pose2D()
    while ancestor not in chains and ancestor in transforms:
        ancestor, parent = transforms[ancestor]
        ancestor_from_base = parent * ancestor_from_base
    return ancestor_from_base.inverse() * chains[ancestor] if ancestor in chains else Pose2D()


def _pose(position: Any, turned: Any) -> Pose2D:
    yaw = math.atan2(2.0 * (turned.w * turned.z + turned.x * turned.y), 1.0 - 2.0 * (turned.y**2 + turned.z**2))
    return Pose2D(position.x, position.y, yaw)


def _time(message: Any) -> float:
    return float(message.header.stamp.sec) + 1e-9 * float(message.header.stamp.nanosec)
