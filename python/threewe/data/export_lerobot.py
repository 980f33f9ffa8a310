"""Export of a recording as a LeRobot dataset."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from threewe._core import Kinematics, instruction_embedding
from threewe.data.exporting import OnProgress, Rows, TickedEpisodes
from threewe.data.mounts import mounts
from threewe.data.recording import DISTURBED, CameraTrack, RecordedEpisode
from threewe.errors import ConfigError
from threewe.language import encodable

STATE = ["x", "y", "theta", "vx", "vy", "omega"]
VELOCITY = ["vx", "vy", "omega"]
OPTIONS = ("version", "codec")


class CameraFrames:
    """Images of a camera as the rows of an episode show them; RGB, as LeRobot has them."""

    def __init__(self, camera: CameraTrack, indices: NDArray[np.int64]) -> None:
        self._camera, self._indices = camera, indices
        self.shape = (camera.height, camera.width, 3)

    def __len__(self) -> int:
        return len(self._indices)

    def packet(self, index: int) -> bytes | None:
        """An H.264 access unit; None where the image was kept raw."""
        return self._camera.packet(int(self._indices[index]))

    def image(self, index: int) -> NDArray[np.uint8]:
        """(H, W, 3) uint8, RGB."""
        return self._camera.color(int(self._indices[index]))[:, :, ::-1]


def write(episodes: TickedEpisodes, output: Path, fps: float, on_progress: OnProgress | None, **options: Any) -> Path:
    """Writes all episodes. See `threewe.data.export`."""
    from threewe.data.lerobot import DatasetWriter

    if fps != int(fps):
        raise ConfigError(f"fps of a LeRobot dataset must be whole, got {fps:g}")
    first = next(iter(episodes))
    judged = all(episode.success is not None for episode in episodes)  # a column has no third value
    features = _features(first, judged)
    with DatasetWriter(output, fps=int(fps), features=features, robot_type=first.robot_type, **options) as writer:
        for done, episode in enumerate(episodes, 1):
            if _features(episode, judged) != features or episode.robot_type != first.robot_type:
                raise ConfigError(
                    f"{episode.file}: robot '{episode.robot_type}' or its sensors differ from those of {first.file}: "
                    "export robots of different kinds into datasets of their own"
                )
            rows = Rows.of(episode, fps)
            videos = {_video(name): _frames(episode, name, rows) for name in episode.cameras}
            writer.add_episode(_columns(episode, rows, judged), _tasks(episode, rows), videos)
            if on_progress is not None:
                on_progress(done, len(episodes))
    return output


def _video(camera: str) -> str:
    return f"observation.images.{camera}"


def _axes(episode: RecordedEpisode) -> list[int]:
    """Which of VELOCITY drive its robot: a differential base has no vy."""
    differential = episode.hardware and episode.profile.kinematics is Kinematics.differential
    return [0, 2] if differential else [0, 1, 2]


def _features(episode: RecordedEpisode, judged: bool) -> dict[str, dict[str, Any]]:
    """What each row holds."""
    velocity = [VELOCITY[axis] for axis in _axes(episode)]
    features: dict[str, dict[str, Any]] = {
        "observation.state": {"dtype": "float32", "shape": (len(STATE),), "names": STATE},
        "action": {"dtype": "float32", "shape": (len(velocity),), "names": velocity},
        "action.requested": {"dtype": "float32", "shape": (len(velocity),), "names": velocity},
        "observation.environment_state": {"dtype": "float32", "shape": (64,), "names": None},
        "takeover": {"dtype": "bool", "shape": (1,), "names": None},
        "next.done": {"dtype": "bool", "shape": (1,), "names": None},
    }
    if judged:
        features["next.success"] = {"dtype": "bool", "shape": (1,), "names": None}
    if DISTURBED in episode.metadata:
        features[DISTURBED] = {"dtype": "bool", "shape": (1,), "names": None}
    _, actions = episode.steps
    if len(actions):
        features["action.step"] = {"dtype": "float32", "shape": (actions.shape[1],), "names": None}
    if "lidar" in episode.sensors and len(lidar := episode.lidar()):
        features["observation.lidar"] = {"dtype": "float32", "shape": (lidar.ranges.shape[1],), "names": None}
    if "imu" in episode.sensors and len(episode.imu()):
        names = ["wx", "wy", "wz", "ax", "ay", "az"]
        features["observation.imu"] = {"dtype": "float32", "shape": (6,), "names": names}
    for name in episode.cameras:
        camera = episode.camera(name)
        names = ["height", "width", "channels"]
        features[_video(name)] = {"dtype": "video", "shape": (camera.height, camera.width, 3), "names": names}
    for name, mount in mounts(episode.profile).items() if episode.hardware else ():
        for feature in {_video(name), f"observation.{name}"} & features.keys():
            features[feature]["info"] = {"base_from_sensor": [*mount.base_from_sensor], "height": mount.height}
    return features


def _columns(episode: RecordedEpisode, rows: Rows, judged: bool) -> dict[str, NDArray[Any]]:
    """All that is no video."""
    last = (np.arange(len(rows.time)) == len(rows.time) - 1)[:, None]
    axes = _axes(episode)
    columns: dict[str, NDArray[Any]] = {
        "observation.state": np.hstack([episode.pose, episode.velocity])[rows.ticks].astype(np.float32),
        "action": rows.following(episode.executed[:, axes]),
        "action.requested": rows.following(episode.requested[:, axes]),
        "observation.environment_state": embeddings_of(_tasks(episode, rows)),
        "takeover": episode.takeover[np.minimum(rows.ticks + 1, len(episode.time) - 1)][:, None],
        "next.done": last,
    }
    if judged:
        columns["next.success"] = last & bool(episode.success)
    if (disturbed := episode.disturbed) is not None:
        columns[DISTURBED] = rows.following(disturbed.astype(np.float64)[:, None]) > 0.0
    _, actions = episode.steps
    if len(actions):
        columns["action.step"] = actions.astype(np.float32)
    if "lidar" in episode.sensors and len(lidar := episode.lidar()):
        columns["observation.lidar"] = lidar.ranges[rows.samples(lidar.received)]
    if "imu" in episode.sensors and len(imu := episode.imu()):
        both = np.hstack([imu.angular_velocity, imu.linear_acceleration])
        columns["observation.imu"] = both[rows.samples(imu.received)].astype(np.float32)
    return columns


def embeddings_of(tasks: list[str]) -> NDArray[np.float32]:
    """(rows, 64) of what is to be done: policies without a tokenizer read it."""
    known = {task: np.array(instruction_embedding(encodable(task)), np.float32) for task in set(tasks)}
    return np.stack([known[task] for task in tasks])


def _frames(episode: RecordedEpisode, name: str, rows: Rows) -> CameraFrames:
    camera = episode.camera(name)
    return CameraFrames(camera, rows.samples(camera.received))


def _tasks(episode: RecordedEpisode, rows: Rows) -> list[str]:
    """The task of each row: the episode's, or what the robot was asked for since."""
    tasks = np.full(len(rows.time), episode.task, dtype=object)
    for since, text in episode.instructions:
        tasks[rows.time >= since] = text
    return [str(task) for task in tasks]
