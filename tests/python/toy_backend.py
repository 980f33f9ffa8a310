"""Backends for the tests: an honest one in Python, and a handful that misbehave."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterable

import numpy as np
from threewe import Features, Kinematics, Pose2D, SensorInfo, SensorType, Velocity
from threewe.backend import Backend, BackendOptions, IMUReading, LidarReading, OdometryReading, Reading, Truth


class QuietBackend(Backend):
    """Obeys at once, in a place where the lidar hits nothing. One reading of each sensor every 20 ms."""

    lockstep = True
    rates = (50.0, 50.0, 50.0)

    def __init__(self, options: BackendOptions) -> None:
        super().__init__(options)
        self.pose = Pose2D()
        self.now = 0.0
        self.velocities: list[Velocity] = []
        self.disconnected = 0
        self.gone = threading.Event()

    @property
    def features(self) -> Features:
        types = (SensorType.lidar, SensorType.imu, SensorType.odometry)
        sensors = [SensorInfo(type.name, type, rate) for type, rate in zip(types, self.rates, strict=True)]
        return Features(sensors, Kinematics.holonomic, lockstep=self.lockstep)

    def connect(self) -> None:
        pass

    def disconnect(self) -> None:
        self.disconnected += 1
        self.gone.set()

    def step(self, t: float, velocity: Velocity) -> Iterable[Reading]:
        seconds, self.now = t - self.now, t
        self.velocities.append(velocity)
        self.pose = self.pose * Pose2D(*(seconds * component for component in velocity))
        return self.readings(t, velocity)

    def readings(self, t: float, velocity: Velocity) -> list[Reading]:
        assert self.profile.lidar is not None
        ranges = np.full(self.profile.lidar.beams, self.profile.lidar.range_max, np.float32)
        return [
            LidarReading(measured=t, ranges=ranges, angle_min=-math.pi),
            IMUReading(
                measured=t, angular_velocity=(0.0, 0.0, velocity.omega), linear_acceleration=np.array([0.0, 0.0, 9.81])
            ),
            OdometryReading(measured=t, pose=self.pose, velocity=velocity),
        ]


class Simulator(QuietBackend):
    """One that can be trained in: it goes through the walls of its scene, and the lidar sees none of them."""

    @property
    def features(self) -> Features:
        quiet = super().features
        return Features(quiet.sensors, quiet.kinematics, lockstep=True, deterministic=True, can_reset=True)

    def reset(self, seed: int, pose: Pose2D | None) -> None:
        self.seed = seed
        self.start = self.true_pose = pose or Pose2D()
        self.pose = Pose2D()
        self.driven = self.now = 0.0
        self.velocity = Velocity()

    def connect(self) -> None:
        self.reset(self.options.seed, self.options.start_pose)

    def step(self, t: float, velocity: Velocity) -> Iterable[Reading]:
        self.driven += math.hypot(velocity.vx, velocity.vy) * (t - self.now)
        readings = super().step(t, velocity)
        self.true_pose, self.velocity = self.start * self.pose, velocity
        return readings

    def truth(self) -> Truth:
        return Truth(start=self.start, pose=self.true_pose, velocity=self.velocity, distance_driven=self.driven)
