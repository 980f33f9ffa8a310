"""Export of a recording as one HDF5 file; `docs/recordings-hdf5.md` has the layout."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from threewe._extras import needed_for
from threewe.data.exporting import OnProgress, TickedEpisodes, appearing, episode_name
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

with needed_for("format hdf5", "data"):
    import h5py

OPTIONS = ("hardware",)
VERSION = 1
POSE, VELOCITY, VECTOR = ("x", "y", "theta"), ("vx", "vy", "omega"), ("x", "y", "z")
POSE_UNITS, VELOCITY_UNITS = "m, m, rad", "m/s, m/s, rad/s"

Attributes = dict[str, Any]
Column = tuple[str, NDArray[Any], Attributes]


def write(
    episodes: TickedEpisodes, output: Path, fps: float, on_progress: OnProgress | None, *, hardware: str | None = None
) -> Path:
    """Writes all episodes. See `threewe.data.export`."""
    del fps  # every sample is kept
    with appearing(output) as place, h5py.File(place, "w") as file:
        file.attrs.update({"format": "3we recording", "version": VERSION})
        for done, episode in enumerate(episodes, 1):
            _write_episode(file.create_group(episode_name(episode)), episode, hardware)
            if on_progress is not None:
                on_progress(done, len(episodes))
    return output


def _write_episode(group: h5py.Group, episode: RecordedEpisode, hardware: str | None) -> None:
    attributes = {
        "index": episode.index,
        "robot": episode.robot,
        "robot_type": episode.robot_type,
        "task": _text(episode.task),
        "recovered": episode.recovered,
        "started": episode.started,
        "control_rate": episode.control_rate,
        "metadata": json.dumps(episode.metadata),
    }
    group.attrs.update(attributes)
    if episode.success is not None:
        group.attrs["success"] = episode.success
    if episode.scene_from_map is not None:
        group.attrs["scene_from_map"] = [*episode.scene_from_map]
    group["hardware"] = _text(episode.hardware)  # too long for an attribute
    for name, values, more in _ticks(episode):
        _add(group, f"ticks/{name}", values, more)
    steps, actions = episode.steps
    if len(steps):
        _add(group, "steps/time", steps, {"units": "s"})
        _add(group, "steps/action", actions, {})
    if episode.instructions:
        _add(group, "instructions/time", np.array([since for since, _ in episode.instructions]), {"units": "s"})
        texts = [_text(text) for _, text in episode.instructions]
        group.create_dataset("instructions/text", data=texts, dtype=h5py.string_dtype())
    places = mounts(profile_of(episode, hardware))
    for name, track in episode.tracks().items():
        _write_track(group.create_group(f"sensors/{name}"), track)
    for name in episode.cameras:
        _write_camera(group.create_group(f"sensors/{name}"), episode.camera(name))
    for name in places.keys() & group.get("sensors", {}).keys():
        place = places[name]
        group[f"sensors/{name}"].attrs.update({"base_from_sensor": [*place.base_from_sensor], "height": place.height})


def _ticks(episode: RecordedEpisode) -> Iterator[Column]:
    """What there is of every tick."""
    body = {"units": VELOCITY_UNITS, "columns": VELOCITY, "frame": "base"}
    pose = {"units": POSE_UNITS, "columns": POSE}
    yield "time", episode.time, {"units": "s"}
    yield "pose", episode.pose, {**pose, "frame": "map"}
    yield "odom_from_base", episode.odom_from_base, {**pose, "frame": "odom"}
    if episode.true_pose is not None:
        yield "true_pose", episode.true_pose, {**pose, "frame": "scene"}
    yield "velocity", episode.velocity, body
    yield "requested", episode.requested, body
    yield "executed", episode.executed, body
    yield "takeover", episode.takeover, {}


def _write_track(group: h5py.Group, track: Track) -> None:
    """The samples of a sensor."""
    meters = {"units": "m"}
    match track:
        case LidarTrack():
            fixed = ("angle_min", "angle_increment", "time_increment", "range_min", "range_max")
            group.attrs.update({"type": "lidar", **{name: getattr(track, name) for name in fixed}})
            columns: list[Column] = [("ranges", track.ranges, meters)]
        case IMUTrack():
            group.attrs["type"] = "imu"
            columns = [
                ("angular_velocity", track.angular_velocity, {"units": "rad/s", "columns": VECTOR}),
                ("linear_acceleration", track.linear_acceleration, {"units": "m/s^2", "columns": VECTOR}),
            ]
        case OdometryTrack():
            group.attrs["type"] = "odometry"
            columns = [
                ("pose", track.pose, {"units": POSE_UNITS, "columns": POSE, "frame": "odom"}),
                ("velocity", track.velocity, {"units": VELOCITY_UNITS, "columns": VELOCITY, "frame": "base"}),
            ]
        case BatteryTrack():
            group.attrs["type"] = "battery"
            columns = [
                ("voltage", track.voltage, {"units": "V"}),
                ("current", track.current, {"units": "A"}),
                ("charge", track.charge, {"units": "1"}),
            ]
        case RangeTrack():
            limits = ("field_of_view", "range_min", "range_max")
            group.attrs.update({"type": "ultrasonic", **{name: getattr(track, name) for name in limits}})
            columns = [("range", track.range, meters)]
    for name, values, more in [*_stamps(track), *columns]:
        _add(group, name, values, more)


def _write_camera(group: h5py.Group, camera: CameraTrack) -> None:
    """Images one by one, since all of them may be larger than the memory."""
    pinhole = camera.intrinsics
    group.attrs.update({"type": "camera", "fx": pinhole.fx, "fy": pinhole.fy, "cx": pinhole.cx, "cy": pinhole.cy})
    for name, values, more in _stamps(camera):
        _add(group, name, values, more)
    frames, height, width = len(camera), camera.height, camera.width
    packed: dict[str, Any] = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
    color = group.create_dataset(
        "color", (frames, height, width, 3), np.uint8, chunks=(1, height, width, 3), **packed | {"shuffle": False}
    )
    color.attrs["color_space"] = "RGB"
    for i in range(frames):
        color[i] = camera.color(i)[..., ::-1]
    if camera.has_depth:
        depth = group.create_dataset("depth", (frames, height, width), np.uint16, chunks=(1, height, width), **packed)
        depth.attrs.update({"units": "mm", "invalid": 0})
        for i in range(frames):
            depth[i] = camera.depth(i)


def _stamps(track: Track | CameraTrack) -> list[Column]:
    seconds = {"units": "s"}
    return [("measured", track.measured, seconds), ("received", track.received, seconds)]


def _add(group: h5py.Group, name: str, values: NDArray[Any], attributes: Attributes) -> None:
    """A dataset with its units and frame; compressed, where it is large enough to be worth it."""
    packed = {"compression": "gzip", "compression_opts": 4, "shuffle": True} if values.nbytes > 4096 else {}
    group.create_dataset(name, data=values, **packed).attrs.update(attributes)


def _text(text: str) -> str:
    """HDF5's strings end at a NUL."""
    return text.replace("\0", "\ufffd")
