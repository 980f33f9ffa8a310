"""Episodes to look at: a contact sheet of a recording or a LeRobot dataset, and recordings in Rerun."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from threewe._arguments import as_file, as_seed
from threewe._core import Pose2D, RobotProfile, Scene, profile_names
from threewe._extras import needed_for
from threewe.data.exporting import OnProgress, appearing, has_ticks
from threewe.data.mounts import profile_of
from threewe.data.recording import LidarTrack, RecordedEpisode, Recording
from threewe.errors import ConfigError, ContractError

with needed_for("contact sheets", "data"):
    from PIL import Image

    from threewe.data.contact_sheet import FRAME_WIDTH, EpisodeRow, draw_sheet

if TYPE_CHECKING:
    from threewe.data.lerobot import Dataset
    from threewe.data.lerobot.dataset import Episode

MOST = 12
"""Episodes on a sheet, unless they are named."""
WALLS_EVERY = 5  # scans; of those between, the points would lie on the same walls


def contact_sheet(
    source: str | os.PathLike[str] | Recording | Dataset,
    *,
    episodes: Sequence[int] | None = None,
    frames: int = 5,
    on_progress: OnProgress | None = None,
) -> Image.Image:
    """A picture of episodes, a row each: task, success, length, frames of its first camera and its trajectory.

    Episodes of robots without a camera show what the lidar saw.

    Args:
        source: a recording or a LeRobot dataset, or the folder of one.
        episodes: their numbers; the first twelve where left out.
        frames: so many of each episode.
        on_progress: called with the numbers of episodes drawn and of all.

    Raises:
        ConfigError: it is neither, has no such episode, or a file in it is wrong.
        ContractError: `frames` is not 1 to 20.
    """
    count = as_seed("frames", frames, 32)
    if not 1 <= count <= 20:
        raise ContractError(f"frames must lie in [1, 20], got {count}")
    opened = open_source(source)
    if isinstance(opened, Recording):
        name, numbers = opened.path.resolve().name, opened.numbers
    else:
        name, numbers = opened.root.resolve().name, [episode.index for episode in opened.episodes]
    chosen = _chosen(numbers, episodes, name)
    rows: list[EpisodeRow] = []
    for done, place in enumerate(chosen, 1):
        if isinstance(opened, Recording):
            if has_ticks(episode := opened[place]):
                rows.append(_recorded_row(episode, count))
        else:
            rows.append(_dataset_row(opened, opened.episodes[place], count))
        if on_progress is not None:
            on_progress(done, len(chosen))
    if not rows:
        raise ConfigError(f"{name}: no episode has any ticks")
    return draw_sheet(name, rows, len(numbers))


def show(
    source: str | os.PathLike[str] | Recording | Dataset,
    output: str | os.PathLike[str],
    *,
    episodes: Sequence[int] | None = None,
    frames: int = 5,
    on_progress: OnProgress | None = None,
) -> Path:
    """Saves a contact sheet as PNG. See `contact_sheet`.

    Raises:
        ConfigError: the output does not end in .png, exists, or cannot be written.
    """
    path = as_file("output", output)
    if path.suffix != ".png":
        raise ConfigError(f"{path}: a contact sheet is a picture: name a file that ends in .png")
    with appearing(path) as place:
        contact_sheet(source, episodes=episodes, frames=frames, on_progress=on_progress).save(place, optimize=True)
    return path


def show_in_rerun(
    source: str | os.PathLike[str] | Recording, episode: int | None = None, *, hardware: str | None = None
) -> None:
    """Opens one episode of a recording, the first where left out, in a window of Rerun.

    Raises:
        ConfigError: no display, no Rerun, no such episode, or a LeRobot dataset.
    """
    from threewe._viewer_sinks import has_display
    from threewe.data import export_rerun

    opened = open_source(source)
    if not isinstance(opened, Recording):
        raise ConfigError(f"{opened.root}: Rerun shows recordings; of a LeRobot dataset there is the contact sheet")
    if not has_display():
        raise ConfigError(
            "there is no display for a window of Rerun: export to format 'rerun', and open the file elsewhere"
        )
    place = 0 if episode is None else _chosen(opened.numbers, [episode], opened.path.name)[0]
    export_rerun.show(opened[place], "rerun", hardware)


def open_source(source: str | os.PathLike[str] | Recording | Dataset) -> Recording | Dataset:
    """The recording or LeRobot dataset of a folder. Raises ConfigError."""
    if not isinstance(source, str | os.PathLike):
        return source
    path = as_file("source", source)
    if (path / "meta").is_dir():
        from threewe.data.lerobot import Dataset

        return Dataset.open(path)
    return Recording(path)


def _chosen(numbers: list[int], wanted: Sequence[int] | None, name: str) -> list[int]:
    """Places in the source of the episodes that are shown; all robots of each."""
    if wanted is None:
        return list(range(min(len(numbers), MOST)))
    if missing := set(wanted) - set(numbers):
        known = f"{min(numbers)} to {max(numbers)}"
        raise ConfigError(f"{name}: there is no episode {min(missing)}; there are {len(numbers)}, numbered {known}")
    return [place for number in wanted for place, found in enumerate(numbers) if found == number]


def _recorded_row(episode: RecordedEpisode, count: int) -> EpisodeRow:
    """Of a recording. In a known scene the true trajectory is drawn, or what the robot believed among its scans."""
    profile, scene, truth = _profile(episode), _scene(episode), episode.true_pose
    in_scene = scene is not None and truth is not None
    stamps, images = _frames(episode, profile, count)
    return EpisodeRow(
        title=f"Episode {episode.index}" + (f", robot {episode.robot}" if episode.robot else ""),
        task=episode.task,
        success=episode.success,
        robot=episode.robot_type,
        seconds=len(episode.time) / episode.control_rate,
        times=[stamp - float(episode.time[0]) for stamp in stamps],
        images=images,
        path=truth if in_scene and truth is not None else episode.pose,
        scene=scene if in_scene else None,
        profile=profile,
        walls=np.empty((0, 2)) if in_scene else _walls(episode, profile),
        note="cut off" if episode.recovered else "",
    )


def _frames(
    episode: RecordedEpisode, profile: RobotProfile | None, count: int
) -> tuple[list[float], list[Image.Image]]:
    """Times and pictures, evenly over the episode: of a camera, or of the lidar where there is none."""
    at = np.linspace(float(episode.time[0]), float(episode.time[-1]), count)
    if episode.cameras:
        camera = episode.camera(episode.cameras[0])
        nearest = [int(np.abs(camera.received - time).argmin()) for time in at]
        images = [Image.fromarray(np.ascontiguousarray(camera.color(i)[..., ::-1])) for i in nearest]
        return [float(camera.received[i]) for i in nearest], images
    if "lidar" in episode.sensors and len(lidar := episode.lidar()):
        from threewe.data.contact_sheet import draw_scan

        nearest = [int(np.abs(lidar.received - time).argmin()) for time in at]
        mount = profile.lidar.base_from_lidar if profile and profile.lidar else Pose2D()
        pictures = [draw_scan(_hits(lidar.ranges[i], lidar, mount), mount, profile, FRAME_WIDTH) for i in nearest]
        return [float(lidar.received[i]) for i in nearest], pictures
    return [], []


def _returned(ranges: NDArray[np.float32], lidar: LidarTrack) -> NDArray[np.int64]:
    """The beams that came back."""
    return np.flatnonzero((ranges > 0.0) & (ranges < lidar.range_max))


def _hits(ranges: NDArray[np.float32], lidar: LidarTrack, mount: Pose2D) -> NDArray[np.float64]:
    """(N, 2) [m] in the base frame, of the beams that came back."""
    beams = _returned(ranges, lidar)
    angles = mount.theta + lidar.angle_min + beams * lidar.angle_increment
    return np.stack([mount.x + ranges[beams] * np.cos(angles), mount.y + ranges[beams] * np.sin(angles)], axis=1)


def _walls(episode: RecordedEpisode, profile: RobotProfile | None) -> NDArray[np.float64]:
    """(N, 2) [m] in `map`: what the lidar hit, from where the robot believed to be."""
    if "lidar" not in episode.sensors or profile is None or profile.lidar is None:
        return np.empty((0, 2))
    lidar, mount = episode.lidar(), profile.lidar.base_from_lidar
    heading, points = np.unwrap(episode.pose[:, 2]), [np.empty((0, 2))]
    for i in range(0, len(lidar), WALLS_EVERY):
        beams = _returned(lidar.ranges[i], lidar)
        times = lidar.measured[i] + beams * lidar.time_increment  # the robot drives on while the lidar turns
        x, y, theta = (np.interp(times, episode.time, values) for values in (*episode.pose.T[:2], heading))
        ahead, left = _hits(lidar.ranges[i], lidar, mount).T
        c, s = np.cos(theta), np.sin(theta)
        points.append(np.stack([x + c * ahead - s * left, y + s * ahead + c * left], axis=1))
    return np.concatenate(points)


def _dataset_row(dataset: Dataset, episode: Episode, count: int) -> EpisodeRow:
    """Of a LeRobot dataset, made by any program."""
    features, robot = dataset.info.features, dataset.info.robot_type or ""
    columns = episode.columns()
    cameras = [name for name in episode.cameras() if not features[name].is_depth]
    nearest = np.linspace(0, episode.length - 1, count).round().astype(int).tolist() if cameras else []
    images: list[Image.Image] = []
    if cameras:
        video = episode.video(cameras[0])
        images = [Image.fromarray(np.ascontiguousarray(video.image(i))) for i in nearest]
    return EpisodeRow(
        title=f"Episode {episode.index}",
        task=", ".join(episode.tasks),
        success=episode.success(columns),
        robot=robot,
        seconds=episode.length / dataset.fps,
        times=[i / dataset.fps for i in nearest],
        images=images,
        path=_dataset_path(dataset, columns),
        scene=None,
        profile=RobotProfile.load(robot) if robot in profile_names() else None,
        walls=np.empty((0, 2)),
        note="",
    )


def _dataset_path(dataset: Dataset, columns: dict[str, NDArray[np.float64]]) -> NDArray[np.float64]:
    """(N, 3) x, y, theta, where the state has numbers of these names; (0, 3) else."""
    state = dataset.info.features.get("observation.state")
    names = state.names if state is not None else None
    if not isinstance(names, list) or not {"x", "y"} <= set(names):
        return np.empty((0, 3))
    values = columns["observation.state"].reshape(-1, len(names)).astype(np.float64)
    theta = values[:, names.index("theta")] if "theta" in names else np.zeros(len(values))
    return np.stack([values[:, names.index("x")], values[:, names.index("y")], theta], axis=1)


def _profile(episode: RecordedEpisode) -> RobotProfile | None:
    """None where it is not to be had any more: the robot is drawn as a disc."""
    try:
        return profile_of(episode)
    except ConfigError:
        return None


def _scene(episode: RecordedEpisode) -> Scene | None:
    """None where it is not to be had any more."""
    try:
        return Scene.load(episode.origin.scene) if episode.origin and episode.origin.scene else None
    except ConfigError:
        return None
