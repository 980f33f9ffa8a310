"""Export of a recording as Rerun's .rrd files, one an episode, laid out like the live viewer."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from threewe._core import Pose2D, RobotProfile, Scene
from threewe._extras import needed_for
from threewe.data.exporting import OnProgress, TickedEpisodes, episode_name, write_episodes
from threewe.data.mounts import Mount, mounts, profile_of
from threewe.data.recording import BatteryTrack, CameraTrack, LidarTrack, RangeTrack, RecordedEpisode
from threewe.errors import ConfigError

with needed_for("format rerun", "viz"):
    import rerun as rr

    from threewe import _viewer_layout as layout
    from threewe import _viewer_scene as solids
    from threewe import _viewer_sinks as sinks
    from threewe import drawing as d
    from threewe.viewer import ESTIMATED_COLOR, PATH_STEP, PATHS, TRUE_COLOR, color_image, depth_image, series

OPTIONS = ("hardware",)
FAR = 8.0  # [m] to which the colours of depth images reach, of a camera whose range is not known


def write(
    episodes: TickedEpisodes, output: Path, fps: float, on_progress: OnProgress | None, *, hardware: str | None = None
) -> Path:
    """Writes all episodes. See `threewe.data.export`."""
    del fps  # every sample is kept

    def write_one(episode: RecordedEpisode, path: Path) -> None:
        show(episode, str(path), hardware)

    return write_episodes(episodes, output, ".rrd", on_progress, write_one)


def show(episode: RecordedEpisode, where: str, hardware: str | None = None) -> None:
    """Sends an episode to a viewer (`rerun` or `web`) or to a file that ends in .rrd.

    Raises:
        ConfigError: an unknown viewer, or no display to open a window on.
    """
    sinks.check_sink(where)
    if len(episode.time) == 0:
        raise ConfigError(f"{episode.file}: has no ticks")
    drawn = EpisodeDrawing(episode, where, profile_of(episode, hardware))
    drawn.draw_what_stays()
    drawn.draw_poses()
    drawn.draw_signals()
    drawn.draw_readings()
    for name in episode.cameras:
        drawn.draw_camera(name, episode.camera(name))
    drawn.end()


class EpisodeDrawing:
    """An episode in Rerun. All below `scene` is the truth, all below `map` what the robot knew, as in the live viewer.

    `signals/error` is how far the robot's belief is from the truth, where it is known how `map` lies in the scene.
    """

    def __init__(self, episode: RecordedEpisode, where: str, profile: RobotProfile) -> None:
        self._episode, self._profile = episode, profile
        self._mounts = mounts(profile)
        self._scene = _scene_of(episode)
        cameras = [episode.camera(name) for name in episode.cameras]
        blueprint = layout.layout(self._scene, bool(cameras), any(camera.has_depth for camera in cameras))
        self._recording = sinks.open_recording(where, blueprint)
        self._recording.send_recording_name(f"{episode_name(episode)} {episode.task}".strip())
        self._heading = np.unwrap(episode.pose[:, 2])

    def end(self) -> None:
        """A file is complete then."""
        self._recording.flush()
        self._recording.disconnect()

    def draw_what_stays(self) -> None:
        """The robot's body, the scene, and the names of the signals."""
        log, episode = self._recording.log, self._episode
        log("/", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        log("map/estimated_robot", solids.body_outline(self._profile, ESTIMATED_COLOR), static=True)
        for name, width in (("requested", 1.0), ("executed", 2.0)):
            names = [f"{axis} {name}" for axis in ("vx", "vy", "omega")]
            log(f"signals/velocity/{name}", series(names, width), static=True)
        if self._scene:
            for entity, solid in solids.scene_solids(self._scene):
                log(f"scene/{entity}", solid, static=True)
        if episode.true_pose is not None:
            log("scene/true_robot", solids.body_mesh(self._profile, TRUE_COLOR), static=True)
        if episode.scene_from_map is not None:
            log("map", solids.transform(episode.scene_from_map), static=True)

    def draw_poses(self) -> None:
        """Where the robot was, and its path so far."""
        episode = self._episode
        self._draw_path("map/estimated", episode.pose)
        if (truth := episode.true_pose) is not None:
            self._draw_path("scene/true", truth)
        if truth is not None and episode.scene_from_map is not None:
            believed = [episode.scene_from_map * Pose2D(*pose) for pose in episode.pose]
            errors = [Pose2D(*true).distance(place) for true, place in zip(truth, believed, strict=True)]
            self._send("signals/error", episode.time, np.array(errors))

    def draw_signals(self) -> None:
        """What was asked for, and what the safety gate let through."""
        self._send("signals/velocity/requested", self._episode.time, self._episode.requested)
        self._send("signals/velocity/executed", self._episode.time, self._episode.executed)
        for since, text in [(float(self._episode.time[0]), self._episode.task), *self._episode.instructions]:
            self._at(since)
            self._recording.log("instruction", rr.TextLog(text))

    def draw_readings(self) -> None:
        """Scans, sonar and the battery, each from where the robot believed to be when it was measured."""
        for name, track in self._episode.tracks().items():
            match track:
                case LidarTrack() if name in self._mounts:
                    self._draw_scans(name, track, self._mounts[name])
                case RangeTrack() if name in self._mounts:
                    self._draw_sonar(name, track, self._mounts[name])
                case BatteryTrack():
                    self._send("signals/battery/charge", track.received, 100.0 * track.charge)
                case _:  # inertial units and wheels are seen in the poses
                    pass

    def draw_camera(self, name: str, camera: CameraTrack) -> None:
        """Colour as the video that was recorded, and depth, from where the camera was."""
        entity = f"map/{name}"
        log, mount = self._recording.log, self._mounts.get(name)
        log(entity, solids.frustum(camera.intrinsics), static=True)
        spec = self._profile.camera
        farthest = spec.depth.range_max if spec and spec.depth else FAR
        encoded = any(camera.packet(i) is not None for i in range(len(camera)))
        if encoded:
            log(f"{entity}/color", rr.VideoStream(codec=rr.VideoCodec.H264), static=True)
        for i, received in enumerate(camera.received.tolist()):
            self._at(received)
            if mount is not None:
                place = self._pose_at(float(camera.measured[i])) * mount.base_from_sensor
                log(entity, solids.transform(place, mount.height))
            packet = camera.packet(i)
            if packet is not None:
                log(f"{entity}/color", rr.VideoStream.from_fields(sample=packet))
            else:
                log(f"{entity}/color{'_raw' * encoded}", color_image(camera.color(i)))
            if camera.has_depth:
                log(f"{entity}/depth", depth_image(camera.depth(i).astype(np.float32) / 1000.0, farthest))

    def _draw_path(self, name: str, poses: NDArray[np.float64]) -> None:
        """The robot at every tick, and one more piece of its path each few centimetres."""
        color, radius, z = PATHS[name]
        last = poses[0]
        for time, pose in zip(self._episode.time.tolist(), poses, strict=True):
            self._at(time)
            self._recording.log(f"{name}_robot", solids.transform(Pose2D(*pose)))
            if np.hypot(*(pose - last)[:2]) >= PATH_STEP:
                strip = [(*last[:2], z), (*pose[:2], z)]
                self._recording.log(f"{name}_path", rr.LineStrips3D([strip], colors=[color], radii=radius))
                last = pose

    def _draw_scans(self, name: str, lidar: LidarTrack, mount: Mount) -> None:
        for i, received in enumerate(lidar.received.tolist()):
            ranges = lidar.ranges[i].astype(np.float64)
            beams = solids.hits(ranges, lidar.range_max)
            base = self._poses_at(lidar.measured[i] + beams * lidar.time_increment)
            scan = ranges, beams, lidar.angle_min, lidar.angle_increment
            self._at(received)
            self._recording.log(f"map/{name}", solids.scan_points(scan, base, mount.base_from_sensor, mount.height))

    def _draw_sonar(self, name: str, sonar: RangeTrack, mount: Mount) -> None:
        for i, received in enumerate(sonar.received.tolist()):
            sensor = self._pose_at(float(sonar.measured[i])) * mount.base_from_sensor
            distance = float(sonar.range[i])
            arc = solids.sonar_arc(sensor, mount.height, distance, sonar.field_of_view)
            arcs = [arc] if 0.0 < distance < sonar.range_max else []
            self._at(received)
            self._recording.log(f"map/{name}", rr.LineStrips3D(arcs, colors=[d.PLAN], radii=0.015))

    def _send(self, entity: str, times: NDArray[np.float64], values: NDArray[np.float64]) -> None:
        """All values of a signal at once."""
        index = rr.TimeColumn(layout.TIMELINE, duration=times)
        self._recording.send_columns(entity, [index], rr.Scalars.columns(scalars=values))

    def _at(self, time: float) -> None:
        self._recording.set_time(layout.TIMELINE, duration=time)

    def _pose_at(self, time: float) -> Pose2D:
        return Pose2D(*(float(values[0]) for values in self._poses_at(np.array([time]))))

    def _poses_at(self, times: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
        """x, y [m] and heading [rad] of the base in `map`, between the ticks."""
        x, y, _ = self._episode.pose.T
        return tuple(np.interp(times, self._episode.time, values) for values in (x, y, self._heading))


def _scene_of(episode: RecordedEpisode) -> Scene | None:
    """The scene of a simulated robot, where it is still to be had: without it, the rest can be shown."""
    if episode.origin is None or not episode.origin.scene:
        return None
    try:
        return Scene.load(episode.origin.scene)
    except ConfigError:
        return None
