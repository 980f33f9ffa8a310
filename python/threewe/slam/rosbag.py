"""rosbag2 recordings: the scans of one lidar, the odometry around each of them, and where the lidar is on the robot."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from threewe._core import LaserScan, Pose2D, check_reading
from threewe._files import require_file
from threewe.errors import ConfigError
from threewe.slam.log import Log, Progress

SCAN, ODOMETRY, TRANSFORMS = "sensor_msgs/msg/LaserScan", "nav_msgs/msg/Odometry", "tf2_msgs/msg/TFMessage"

Scans = list[tuple[float, LaserScan, str]]  # [s], and the frame
Poses = list[tuple[float, Pose2D, str]]


def read_rosbag(path: Path, *, on_progress: Progress | None = None) -> Log:
    """Reads the topic of type LaserScan and the one of type Odometry; where there are several, that with most messages.
    Scans before the first or after the last odometry are skipped and counted. Raises ConfigError.
    """
    for file in sorted(path.iterdir()) if path.is_dir() else [path]:
        if not file.is_dir():
            require_file(file)
    with ExitStack() as stack:
        with _readable(path, "not a rosbag2 that can be read"):
            reader = stack.enter_context(AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)))
            start, duration = reader.start_time, reader.duration
        return _read(
            path, reader, lambda stamp: on_progress((stamp - start) / max(duration, 1)) if on_progress else None
        )


@contextmanager
def _readable(path: Path, place: str) -> Iterator[None]:
    """What the library raises about bytes that were forged or cut off is of any kind: each is one ConfigError."""
    try:
        yield
    except ConfigError:
        raise
    except Exception as error:
        raise ConfigError(f"{path}: {place}: {str(error)[:200] or type(error).__name__}") from None


def _read(path: Path, reader: AnyReader, tell: Callable[[int], None]) -> Log:
    wanted = [_busiest(path, reader, kind) for kind in (SCAN, ODOMETRY)]
    wanted += [c for c in reader.connections if c.msgtype == TRANSFORMS and c.topic.endswith("tf_static")]
    scans: Scans = []
    odometry: Poses = []
    transforms: dict[str, tuple[str, Pose2D]] = {}
    counts: dict[str, int] = {}
    messages = reader.messages(wanted)
    while True:
        with _readable(path, f"after message {sum(counts.values())}"):
            found = next(messages, None)
        if found is None:
            break
        connection, stamp, data = found
        counts[connection.topic] = counts.get(connection.topic, 0) + 1
        with _readable(path, f"message {counts[connection.topic]} of {connection.topic}"):
            message: Any = reader.deserialize(data, connection.msgtype)
            if connection.msgtype == TRANSFORMS:
                for t in message.transforms:
                    pose = _pose(t.transform.translation, t.transform.rotation)
                    transforms[t.child_frame_id] = t.header.frame_id, pose
            elif connection.msgtype == SCAN:
                scans.append((_time(message), _scan(message), message.header.frame_id))
            else:
                pose = _pose(message.pose.pose.position, message.pose.pose.orientation)
                odometry.append((_time(message), pose, message.child_frame_id))
        tell(stamp)
    if not scans or not odometry:
        raise ConfigError(f"{path}: {len(scans)} scans and {len(odometry)} odometry messages in it; both are needed")
    return _log(path, scans, odometry, transforms)


def _busiest(path: Path, reader: AnyReader, kind: str) -> Any:
    found = [connection for connection in reader.connections if connection.msgtype == kind and connection.msgcount]
    if not found:
        raise ConfigError(f"{path}: no {kind} in it; topics: {', '.join(sorted(reader.topics)) or 'none'}")
    return max(found, key=lambda connection: connection.msgcount)


def _log(path: Path, scans: Scans, odometry: Poses, transforms: dict[str, tuple[str, Pose2D]]) -> Log:
    log = Log(base_from_lidar=_mount(odometry[0][2], scans[0][2], transforms))
    times = np.array([time for time, _, _ in odometry])
    x, y = (np.array([getattr(pose, axis) for _, pose, _ in odometry]) for axis in "xy")
    theta = np.unwrap([pose.theta for _, pose, _ in odometry])
    for number, (time, scan, _) in enumerate(scans, 1):
        if not times[0] <= time <= times[-1]:
            log.skip("scans without odometry around them")
            continue
        place = Pose2D(*(float(np.interp(time, times, values)) for values in (x, y, theta)))
        with _readable(path, f"scan {number}"):
            log.add(time, scan, place)
    if not log.scans:
        raise ConfigError(f"{path}: no scan is between the first and the last odometry: are these stamps of one clock?")
    with _readable(path, "the transforms from the robot to its lidar"):
        check_reading(log.scans[0], log.base_from_lidar)
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
    seen: set[str] = set()
    while ancestor not in chains and ancestor in transforms and ancestor not in seen:
        seen.add(ancestor)
        ancestor, parent = transforms[ancestor]
        ancestor_from_base = parent * ancestor_from_base
    return ancestor_from_base.inverse() * chains[ancestor] if ancestor in chains else Pose2D()


def _pose(position: Any, turned: Any) -> Pose2D:
    x, y, z, w = turned.x, turned.y, turned.z, turned.w
    yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    if not math.isfinite(position.x + position.y + yaw):
        raise ValueError(f"a pose must be finite, got ({position.x:g}, {position.y:g}) and a heading of {yaw:g}")
    return Pose2D(position.x, position.y, yaw)


def _time(message: Any) -> float:
    return float(message.header.stamp.sec) + 1e-9 * float(message.header.stamp.nanosec)
