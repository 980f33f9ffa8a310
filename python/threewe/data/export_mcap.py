"""Export of a recording as MCAP files with Foxglove's schemas; `docs/recordings-mcap.md` has the topics.

The messages of `foxglove-schemas-protobuf` are written by `mcap`: both are small, and leave every version of LeRobot
installable. `foxglove-sdk` can do the same, but takes 54 MB, and LeRobot allows old versions of it only.
"""

from __future__ import annotations

import heapq
import json
from collections.abc import Iterable, Iterator
from operator import itemgetter
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from threewe._core import Pose2D
from threewe._extras import needed_for
from threewe.data.exporting import OnProgress, TickedEpisodes, write_episodes
from threewe.data.mounts import mounts, profile_of
from threewe.data.recording import (
    BatteryTrack,
    CameraTrack,
    IMUTrack,
    LidarTrack,
    OdometryTrack,
    RangeTrack,
    RecordedEpisode,
    Track,
)

with needed_for("format mcap", "data"):
    from mcap.writer import Writer
    from mcap_protobuf.schema import register_schema

    from threewe.data import foxglove

OPTIONS = ("hardware",)

Message = tuple[int, str, Any]
"""When it was at hand [ns since 1970], its topic, and a message of protobuf or a dict for JSON."""


def write(
    episodes: TickedEpisodes, output: Path, fps: float, on_progress: OnProgress | None, *, hardware: str | None = None
) -> Path:
    """Writes all episodes. See `threewe.data.export`."""
    del fps  # every sample is kept

    def write_one(episode: RecordedEpisode, path: Path) -> None:
        with path.open("wb") as file:
            _write_episode(episode, file, hardware)

    return write_episodes(episodes, output, ".mcap", on_progress, write_one)


def _write_episode(episode: RecordedEpisode, file: BinaryIO, hardware: str | None) -> None:
    clock = Clock(episode)
    streams = [_fixed(episode, clock, hardware), _ticks(episode, clock), _instructions(episode, clock)]
    streams += [_samples(name, track, clock) for name, track in episode.tracks().items()]
    streams += [_images(name, episode.camera(name), clock) for name in episode.cameras]
    topics = Topics(Writer(file))
    for time, topic, message in heapq.merge(*streams, key=itemgetter(0)):
        topics.write(time, topic, message)
    about = {
        "index": episode.index,
        "robot": episode.robot,
        "robot_type": episode.robot_type,
        "hardware": episode.hardware,
        "task": episode.task,
        "success": episode.success,
        "recovered": episode.recovered,
        "robot_time_offset_ns": clock.offset,
        "metadata": episode.metadata,
    }
    topics.end({name: value if isinstance(value, str) else json.dumps(value) for name, value in about.items()})


class Clock:
    """Robot time as wall clock: the first tick was when the recording started.

    Attributes:
        offset: [ns] from robot time to time since 1970; whole, so that no stamp loses a nanosecond.
    """

    def __init__(self, episode: RecordedEpisode) -> None:
        self.offset = round(episode.started * 1e9) - round(float(episode.time[0]) * 1e9)

    def __call__(self, time: float) -> int:
        """[ns since 1970] of a robot time [s]."""
        return round(float(time) * 1e9) + self.offset


class Topics:
    """The channels of a file; each is made by its first message."""

    def __init__(self, writer: Writer) -> None:
        self._writer = writer
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        self._counts: dict[str, int] = {}
        writer.start(library="3we")

    def write(self, time: int, topic: str, message: Any) -> None:
        """A message of protobuf, or a dict as JSON."""
        as_json = isinstance(message, dict)
        if topic not in self._channels:
            encoding = "json" if as_json else "protobuf"
            schema = self._json_schema(topic, message) if as_json else self._schema(type(message))
            self._channels[topic] = self._writer.register_channel(topic, encoding, schema)
        data = json.dumps(message).encode() if as_json else message.SerializeToString()
        number = self._counts[topic] = self._counts.get(topic, 0) + 1
        self._writer.add_message(self._channels[topic], time, data, time, number)

    def end(self, about: dict[str, str]) -> None:
        """Finishes the file, with what is known about the episode."""
        self._writer.add_metadata("episode", about)
        self._writer.finish()

    def _schema(self, kind: Any) -> int:
        name = kind.DESCRIPTOR.full_name
        if name not in self._schemas:
            self._schemas[name] = int(register_schema(self._writer, kind))
        return self._schemas[name]

    def _json_schema(self, topic: str, message: dict[str, Any]) -> int:
        """All values of a message are numbers, but for those that are not."""
        kinds: dict[type, dict[str, Any]] = {str: {"type": "string"}, bool: {"type": "boolean"}}
        kinds[list] = {"type": "array", "items": {"type": "number"}}
        properties = {name: kinds.get(type(value), {"type": "number"}) for name, value in message.items()}
        schema = {"type": "object", "properties": properties}
        number: int = self._writer.register_schema(
            f"threewe{topic.replace('/', '.')}", "jsonschema", json.dumps(schema).encode()
        )
        return number


def _fixed(episode: RecordedEpisode, clock: Clock, hardware: str | None) -> Iterator[Message]:
    """Where sensors are on the robot."""
    start = clock(episode.time[0])
    parts = []
    for name, mount in mounts(profile_of(episode, hardware)).items():
        if name in episode.sensors:
            parts.append(foxglove.transform("base", name, mount.base_from_sensor, mount.height, start))
    if episode.scene_from_map is not None:
        parts.append(foxglove.transform("scene", "map", episode.scene_from_map, 0.0, start))
    parts += [foxglove.optical_transform(name, _optical(name), start) for name in episode.cameras]
    if parts:
        yield start, "/tf_static", foxglove.transforms(*parts)


def _ticks(episode: RecordedEpisode, clock: Clock) -> Iterator[Message]:
    """What there is of every tick."""
    steps, actions = episode.steps
    due = iter(zip(steps.tolist(), actions.tolist(), strict=True))
    step = next(due, None)
    truth = episode.true_pose
    for i, seconds in enumerate(episode.time.tolist()):
        time = clock(seconds)
        map_from_base, odom_from_base = Pose2D(*episode.pose[i]), Pose2D(*episode.odom_from_base[i])
        map_from_odom = map_from_base * odom_from_base.inverse()
        parts = [("map", "odom", map_from_odom), ("odom", "base", odom_from_base)]
        yield time, "/tf", foxglove.transforms(*(foxglove.transform(*part, 0.0, time) for part in parts))
        yield time, "/pose", foxglove.pose(map_from_base, "map", time)
        if truth is not None:
            yield time, "/true_pose", foxglove.pose(Pose2D(*truth[i]), "scene", time)
        for topic, values in (
            ("/velocity", episode.velocity),
            ("/action/requested", episode.requested),
            ("/action/executed", episode.executed),
        ):
            yield time, topic, _named(("vx", "vy", "omega"), values[i])
        yield time, "/takeover", {"takeover": bool(episode.takeover[i])}
        while step is not None and step[0] <= seconds + 5e-10:
            yield time, "/action/step", {"action": step[1]}
            step = next(due, None)


def _instructions(episode: RecordedEpisode, clock: Clock) -> Iterator[Message]:
    yield clock(episode.time[0]), "/instruction", {"instruction": episode.task}
    for since, text in episode.instructions:
        yield clock(max(since, float(episode.time[0]))), "/instruction", {"instruction": text}


def _samples(name: str, track: Track, clock: Clock) -> Iterator[Message]:
    """The samples of a sensor; stamped when they were measured, logged when they were at hand."""
    topic = f"/{name}"
    for i, (measured, received) in enumerate(zip(map(clock, track.measured), map(clock, track.received), strict=True)):
        match track:
            case LidarTrack():
                limits = track.angle_min, track.angle_increment, track.range_max
                yield received, topic, foxglove.scan(track.ranges[i], *limits, name, measured)
            case OdometryTrack():
                yield received, topic, foxglove.pose(Pose2D(*track.pose[i]), "odom", measured)
                yield received, f"{topic}/velocity", _named(("vx", "vy", "omega"), track.velocity[i], measured)
            case IMUTrack():
                values = np.concatenate([track.angular_velocity[i], track.linear_acceleration[i]])
                yield received, topic, _named(("wx", "wy", "wz", "ax", "ay", "az"), values, measured)
            case BatteryTrack():
                values = np.array([track.voltage[i], track.current[i], track.charge[i]])
                yield received, topic, _named(("voltage", "current", "charge"), values, measured)
            case RangeTrack():
                yield received, topic, _named(("range",), track.range[i : i + 1], measured)


def _images(name: str, camera: CameraTrack, clock: Clock) -> Iterator[Message]:
    """Colour as the video that was recorded, or as it is where it was kept raw; depth without loss."""
    frame = _optical(name)
    for i, (measured, received) in enumerate(
        zip(map(clock, camera.measured), map(clock, camera.received), strict=True)
    ):
        yield received, f"/{name}/calibration", foxglove.calibration(camera.intrinsics, frame, measured)
        packet = camera.packet(i)
        if packet is not None:
            yield received, f"/{name}/color", foxglove.video(packet, frame, measured)
        else:
            yield received, f"/{name}/color_raw", foxglove.image(camera.color(i), "bgr8", frame, measured)
        if camera.has_depth:
            yield received, f"/{name}/depth", foxglove.image(camera.depth(i), "16UC1", frame, measured)


def _optical(camera: str) -> str:
    return f"{camera}_optical"


def _named(names: Iterable[str], values: NDArray[np.float64], measured: int | None = None) -> dict[str, Any]:
    """Numbers by name, and when they were measured [s, ns since 1970]; JSON has no infinity."""
    found: dict[str, Any] = {n: v if np.isfinite(v) else None for n, v in zip(names, values.tolist(), strict=True)}
    if measured is not None:
        found["timestamp"] = {"sec": measured // 10**9, "nsec": measured % 10**9}
    return found
