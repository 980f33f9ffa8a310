"""Recordings: a folder of journals as a `TrajectoryRecorder` left it, an episode of one robot at a time."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from threewe import _core
from threewe._arguments import as_file
from threewe._core import (
    BatteryState,
    CameraIntrinsics,
    IMUData,
    LaserScan,
    Odometry,
    RangeData,
    ReplayReport,
    RobotProfile,
    Sample,
)
from threewe.data.video import KeyFrameDecoder
from threewe.errors import ConfigError, HardwareError

CONTROL_RATE = 50.0
"""[Hz] of a recording's ticks."""
DISTURBED = "disturbed"
"""Metadata of an episode: when [s] the robot did not do what is to be learnt, such as "3.2-4.1 7-7.5"."""


def spans_to_text(spans: Sequence[tuple[float, float]]) -> str:
    """Spans of time [s] as DISTURBED has them; `RecordedEpisode.disturbed` reads them."""
    return " ".join(f"{begin:.2f}-{end:.2f}" for begin, end in spans)


class Stamped:
    """Readings of one sensor, with their times.

    Attributes:
        measured: (N,) float64 [s] when each was taken.
        received: (N,) float64 [s] when each was at hand.
    """

    def __init__(self, samples: Sequence[Sample]) -> None:
        self.measured = np.array([sample.measured for sample in samples], np.float64)
        self.received = np.array([sample.received for sample in samples], np.float64)

    def __len__(self) -> int:
        return len(self.measured)


class LidarTrack(Stamped):
    """Scans of the lidar.

    Attributes:
        ranges: (N, beams) float32 [m]; no return = `range_max`, invalid = 0.
        angle_min: [rad] of beam 0.
        angle_increment: [rad] from beam to beam.
        time_increment: [s] from beam to beam.
        range_min: [m]
        range_max: [m]
    """

    def __init__(self, samples: Sequence[Sample]) -> None:
        super().__init__(samples)
        scans: list[LaserScan] = [sample.data for sample in samples]  # type: ignore[misc]
        beams = len(scans[0].ranges) if scans else 0
        self.ranges = np.stack([scan.ranges for scan in scans]) if scans else np.zeros((0, beams), np.float32)
        one = scans[0] if scans else LaserScan(np.zeros(1, np.float32), 0.0, 1.0, 0.0, 1.0)
        self.angle_min, self.angle_increment = one.angle_min, one.angle_increment
        self.time_increment = one.time_increment
        self.range_min, self.range_max = one.range_min, one.range_max


class IMUTrack(Stamped):
    """Readings of the inertial unit.

    Attributes:
        angular_velocity: (N, 3) float64 [rad/s]
        linear_acceleration: (N, 3) float64 [m/s^2]
    """

    def __init__(self, samples: Sequence[Sample]) -> None:
        super().__init__(samples)
        readings: list[IMUData] = [sample.data for sample in samples]  # type: ignore[misc]
        self.angular_velocity = np.array([imu.angular_velocity for imu in readings], np.float64).reshape(-1, 3)
        self.linear_acceleration = np.array([imu.linear_acceleration for imu in readings], np.float64).reshape(-1, 3)


class OdometryTrack(Stamped):
    """Pose and velocity by the wheels alone.

    Attributes:
        pose: (N, 3) float64 [m, m, rad] in `odom`
        velocity: (N, 3) float64 [m/s, m/s, rad/s] in the body frame
    """

    def __init__(self, samples: Sequence[Sample]) -> None:
        super().__init__(samples)
        readings: list[Odometry] = [sample.data for sample in samples]  # type: ignore[misc]
        self.pose = np.array([tuple(one.pose) for one in readings], np.float64).reshape(-1, 3)
        self.velocity = np.array([tuple(one.velocity) for one in readings], np.float64).reshape(-1, 3)


class BatteryTrack(Stamped):
    """The state of the battery.

    Attributes:
        voltage: (N,) float64 [V]
        current: (N,) float64 [A]
        charge: (N,) float64, the fraction left
    """

    def __init__(self, samples: Sequence[Sample]) -> None:
        super().__init__(samples)
        readings: list[Any] = [sample.data for sample in samples]
        self.voltage = np.array([one.voltage for one in readings], np.float64)
        self.current = np.array([one.current for one in readings], np.float64)
        self.charge = np.array([one.charge for one in readings], np.float64)


class RangeTrack(Stamped):
    """Ranges of one ultrasonic sensor.

    Attributes:
        range: (N,) float64 [m]; no return = `range_max`, invalid = 0.
        field_of_view: [rad] of the cone of sound.
        range_min: [m]
        range_max: [m]
    """

    def __init__(self, samples: Sequence[Sample]) -> None:
        super().__init__(samples)
        readings: list[RangeData] = [sample.data for sample in samples]  # type: ignore[misc]
        self.range = np.array([one.range for one in readings], np.float64)
        one = readings[0] if readings else RangeData(1.0, 0.0, 1.0, 0.0)
        self.field_of_view, self.range_min, self.range_max = one.field_of_view, one.range_min, one.range_max


Track = LidarTrack | IMUTrack | OdometryTrack | BatteryTrack | RangeTrack
TRACKS: dict[type, type[Track]] = {
    LaserScan: LidarTrack,
    IMUData: IMUTrack,
    Odometry: OdometryTrack,
    BatteryState: BatteryTrack,
    RangeData: RangeTrack,
}
"""By what a sensor's samples hold."""


class CameraTrack:
    """Images of one camera. They stay in the journal until they are asked for.

    Attributes:
        measured: (N,) float64 [s] when each was taken.
        received: (N,) float64 [s] when each was at hand.
        intrinsics: of the pinhole.
    """

    def __init__(self, journal: _core.Journal, frames: list[_core.RecordedFrame], intrinsics: CameraIntrinsics) -> None:
        self._journal, self._frames = journal, frames
        self.measured = np.array([frame.measured for frame in frames], np.float64)
        self.received = np.array([frame.received for frame in frames], np.float64)
        self.intrinsics = intrinsics
        self._decoder: KeyFrameDecoder | None = None

    def __len__(self) -> int:
        return len(self._frames)

    @property
    def height(self) -> int:
        """[px]"""
        return self._frames[0].height if self._frames else self.intrinsics.height

    @property
    def width(self) -> int:
        """[px]"""
        return self._frames[0].width if self._frames else self.intrinsics.width

    @property
    def has_depth(self) -> bool:
        """It measured depth, too."""
        return bool(self._frames) and self._frames[0].has_depth

    def packet(self, index: int) -> bytes | None:
        """An H.264 access unit (Annex B, a key frame with its parameter sets); None where the image was kept raw."""
        frame = self._frames[index]
        return self._journal.color(frame) if frame.encoded else None

    def color(self, index: int) -> NDArray[np.uint8]:
        """(H, W, 3) uint8, BGR."""
        frame = self._frames[index]
        stored = self._journal.color(frame)
        if frame.encoded:
            self._decoder = self._decoder or KeyFrameDecoder((self.height, self.width, 3), "bgr24")
            return self._decoder.decode(stored)
        return np.frombuffer(stored, np.uint8).reshape(frame.height, frame.width, 3)

    def depth(self, index: int) -> NDArray[np.uint16]:
        """(H, W) uint16 [mm] along the optical axis, invalid = 0. Raises HardwareError without a depth camera."""
        frame = self._frames[index]
        if not frame.has_depth:
            raise HardwareError("this camera measured no depth")
        return self._journal.depth(frame)


class RecordedEpisode:
    """What one robot did in one episode.

    Attributes:
        file: the journal.
        index: the episode's number.
        robot: the robot's number among those recorded.
        robot_type: the name of its hardware profile.
        task: what it was to do.
        success: whether that was done; None where it was not judged.
        metadata: whatever was kept beside it.
        recovered: it was cut off while it was recorded.
        started: wall clock at its start [s since 1970].
        scene_from_map: where the robot's `map` frame lies in the scene; None on a real robot, and in a given map
            without an initial pose. For replays and drawings, never for policies.
        control_rate: [Hz] of its ticks.
    """

    control_rate = CONTROL_RATE

    def __init__(self, file: Path, journal: _core.Journal, robot: int) -> None:
        self.file, self.robot = file, robot
        self._journal, self._recorded = journal, journal.robots[robot]
        self.index, self.task, self.success = journal.episode, journal.task, journal.success
        self.metadata, self.recovered, self.started = journal.metadata, journal.recovered, journal.started
        self.robot_type, self.scene_from_map = self._recorded.profile, self._recorded.scene_from_map

    def __repr__(self) -> str:
        return f"RecordedEpisode({self.index}, {self.task!r}, {len(self.time) / CONTROL_RATE:.1f} s)"

    @cached_property
    def time(self) -> NDArray[np.float64]:
        """(T,) [s] robot time at the end of each tick."""
        return self._recorded.time

    @cached_property
    def pose(self) -> NDArray[np.float64]:
        """(T, 3) [m, m, rad] in `map`, as the robot believed at the end of each tick."""
        return self._recorded.pose

    @cached_property
    def odom_from_base(self) -> NDArray[np.float64]:
        """(T, 3) [m, m, rad], without corrections of drift."""
        return self._recorded.odom_from_base

    @cached_property
    def velocity(self) -> NDArray[np.float64]:
        """(T, 3) [m/s, m/s, rad/s] in the body frame, as the robot believed."""
        return self._recorded.velocity

    @cached_property
    def requested(self) -> NDArray[np.float64]:
        """(T, 3) [m/s, m/s, rad/s] that was asked for during each tick, before the safety gate."""
        return self._recorded.requested

    @cached_property
    def executed(self) -> NDArray[np.float64]:
        """(T, 3) [m/s, m/s, rad/s] that the safety gate let through during each tick."""
        return self._recorded.executed

    @cached_property
    def takeover(self) -> NDArray[np.bool_]:
        """(T,) whether a person drove, who corrects a policy."""
        return self._recorded.takeover

    @cached_property
    def true_pose(self) -> NDArray[np.float64] | None:
        """(T, 3) [m, m, rad] in the scene's frame; None on a real robot. For metrics, never for policies."""
        return self._recorded.true_pose if self._recorded.simulated else None

    @cached_property
    def profile(self) -> RobotProfile:
        """The robot as it was recorded, whatever has become of its profile's file.

        Raises:
            ConfigError: its profile was made in code, and has no text that could be recorded.
        """
        if not self.hardware:
            raise ConfigError(
                f"{self.file}: profile '{self.robot_type}' was made in code: exports take another, `hardware`"
            )
        profile = RobotProfile.parse(self.hardware, self.robot_type)
        for camera in self._recorded.cameras:
            if camera.width:
                profile = profile.with_image_size(camera.height, camera.width)
        return profile

    @property
    def hardware(self) -> str:
        """The YAML of the robot's profile; empty where that was made in code."""
        return self._recorded.hardware

    @property
    def origin(self) -> _core.WorldOrigin | None:
        """How the world was made; None where it was none that can be made again, such as a real one."""
        return self._journal.origin

    @property
    def steps(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Times (S,) [s] and actions (S, n) of `record_step`."""
        return self._recorded.step_time, self._recorded.step_action

    @property
    def instructions(self) -> list[tuple[float, str]]:
        """From when on [s] the robot was asked for what, where that changed within the episode."""
        return self._recorded.instructions

    @property
    def disturbed(self) -> NDArray[np.bool_] | None:
        """(T,) where random commands drove the robot; None where the episode's metadata say nothing of it."""
        if DISTURBED not in self.metadata:
            return None
        found = np.zeros(len(self.time), np.bool_)
        for span in str(self.metadata[DISTURBED]).split():
            begin, end = map(float, span.split("-"))
            found |= (self.time >= begin) & (self.time <= end)
        return found

    @property
    def sensors(self) -> list[str]:
        """Names of the robot's sensors."""
        return [sensor.name for sensor in self._recorded.sensors]

    @property
    def cameras(self) -> list[str]:
        """Names of the cameras that were recorded."""
        seen = {frame.sensor for frame in self._recorded.frames}
        return [self.sensors[number] for number in sorted(seen)]

    def samples(self, sensor: str) -> list[Sample]:
        """All of a sensor, in order of arrival. Raises HardwareError, naming the sensors there are."""
        return list(self._samples[self._number(sensor)])

    @cached_property
    def _samples(self) -> list[list[Sample]]:
        """By the sensors' numbers."""
        found: list[list[Sample]] = [[] for _ in self._recorded.sensors]
        for sample in self._recorded.samples:
            found[sample.sensor].append(sample)
        return found

    def _number(self, sensor: str) -> int:
        if sensor not in self.sensors:
            raise HardwareError(f"robot '{self.robot_type}' has no sensor '{sensor}', it has {', '.join(self.sensors)}")
        return self.sensors.index(sensor)

    def tracks(self) -> dict[str, Track]:
        """All readings but images, by the names of the sensors that have any."""
        found: dict[str, Track] = {}
        for name in self.sensors:
            samples = self.samples(name)
            if samples and (kind := TRACKS.get(type(samples[0].data))):
                found[name] = kind(samples)
        return found

    def lidar(self) -> LidarTrack:
        """Its scans."""
        return LidarTrack(self.samples("lidar"))

    def imu(self) -> IMUTrack:
        """The readings of its inertial unit."""
        return IMUTrack(self.samples("imu"))

    def odometry(self) -> OdometryTrack:
        """Pose and velocity by its wheels alone."""
        return OdometryTrack(self.samples("odometry"))

    def battery(self) -> BatteryTrack:
        """The state of its battery."""
        return BatteryTrack(self.samples("battery"))

    def ultrasonic(self, name: str) -> RangeTrack:
        """The ranges of one of its ultrasonic sensors."""
        return RangeTrack(self.samples(name))

    def camera(self, name: str = "camera") -> CameraTrack:
        """The images of one of its cameras."""
        number = self._number(name)
        frames = [frame for frame in self._recorded.frames if frame.sensor == number]
        return CameraTrack(self._journal, frames, self._recorded.cameras[number])

    def replay(self) -> ReplayReport:
        """Makes the simulated world anew, in which all robots of the episode do again what they executed.

        Raises:
            ContractError: the world was none that can be made or restored, such as a real one.
        """
        return self._journal.replay()


class Recording(Sequence[RecordedEpisode]):
    """The episodes of a folder of journals, or of one journal, by their numbers; of each, one for each robot.

    They are read when they are asked for; before that, no more than their headers. What was cut off while it was
    recorded is not among them before `recover`.

    Attributes:
        path: of the folder, or the journal.
        numbers: of each episode.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = as_file("path", path)
        if self.path.is_dir():
            files = list(_core.journals(str(self.path)))
        elif self.path.suffix == ".journal":
            files = [self.path]
        else:
            raise ConfigError(f"{self.path}: no folder of journals, and no file that ends in .journal")
        if not files:
            raise ConfigError(f"{self.path}: there are no finished journals; `threewe data recover` finishes others")
        self._entries: list[tuple[Path, int]] = []  # files and robots
        self.numbers: list[int] = []
        for file in files:
            header = _core.read_journal_header(str(file))
            for robot in range(len(header.robots)):
                self._entries.append((file, robot))
                self.numbers.append(header.episode)
        self._opened: tuple[Path, _core.Journal] | None = None

    def __repr__(self) -> str:
        return f"Recording('{self.path}', {len(self)} episodes)"

    @property
    def episodes(self) -> Sequence[RecordedEpisode]:
        """The same as the recording itself."""
        return self

    def __len__(self) -> int:
        return len(self._entries)

    @overload
    def __getitem__(self, index: int) -> RecordedEpisode: ...
    @overload
    def __getitem__(self, index: slice) -> list[RecordedEpisode]: ...
    def __getitem__(self, index: int | slice) -> RecordedEpisode | list[RecordedEpisode]:
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(len(self)))]
        file, robot = self._entries[index]
        if self._opened is None or self._opened[0] != file:
            self._opened = file, _core.Journal.open(str(file))
        return RecordedEpisode(file, self._opened[1], robot)

    def __iter__(self) -> Iterator[RecordedEpisode]:
        return (self[i] for i in range(len(self)))


def recover(folder: str | os.PathLike[str]) -> list[_core.Recovered]:
    """Finishes what a crash has cut off: what each journal has up to the last sound block becomes an episode.

    Raises:
        RecordingError: the folder cannot be written, or a recorder writes into it.
    """
    return _core.recover_journals(str(as_file("folder", folder)))
