"""Where the sensors of a recorded robot are on its body."""

from __future__ import annotations

from dataclasses import dataclass

from threewe._core import Pose2D, RobotProfile
from threewe.data.recording import RecordedEpisode


@dataclass(frozen=True)
class Mount:
    """Where a sensor is; cameras look along their x axis."""

    base_from_sensor: Pose2D
    height: float  # [m] above the floor


def profile_of(episode: RecordedEpisode, hardware: str | None = None) -> RobotProfile:
    """The profile that an episode was recorded with, or another.

    Raises:
        ConfigError: there is no such profile.
    """
    return episode.profile if hardware is None else RobotProfile.load(hardware)


def mounts(profile: RobotProfile) -> dict[str, Mount]:
    """By the sensor's name. Those that have no place, such as a battery, are left out."""
    found: dict[str, Mount] = {}
    if profile.lidar:
        found["lidar"] = Mount(profile.lidar.base_from_lidar, profile.lidar.height)
    if profile.camera:
        found["camera"] = Mount(profile.camera.base_from_camera, profile.camera.mount_height)
    if profile.ultrasonics:
        for name, place in profile.ultrasonics.mounts.items():
            found[name] = Mount(place, profile.ultrasonics.height)
    return found
