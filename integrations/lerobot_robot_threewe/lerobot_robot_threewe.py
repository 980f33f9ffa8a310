"""Robot of LeRobot: one of 3we, on any backend and behind its safety gate. `lerobot-record --robot.type=threewe`.

LeRobot finds this package by its name. Velocities are `vx.vel`, `vy.vel` [m/s] and `omega.vel` [rad/s]: those of
datasets of 3we, with names that LeRobot's commands pass on. A differential base is driven by two, without `vy.vel`.
Robots in simulation run in real time, as LeRobot's loops do.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from lerobot.robots import Robot, RobotConfig
from threewe import Kinematics, RobotProfile
from threewe.sync import Robot as SyncRobot

HOLD = 0.5
"""[s] that a velocity counts; then the robot stands"""
NAMES = ("vx.vel", "vy.vel", "omega.vel")
"""[m/s], [m/s], [rad/s]; `lerobot-rollout` passes on only names that end in .vel or .pos."""


@RobotConfig.register_subclass("threewe")
@dataclass(kw_only=True)
class ThreeweRobotConfig(RobotConfig):
    """`--robot.backend=mock --robot.scene=office_v2 ...`: the options of `threewe.Robot`."""

    backend: str = "mock"
    hardware: str = "3we_standard_v2"
    scene: str = "office_v2"
    seed: int = 0
    image_size: list[int] = field(default_factory=lambda: [240, 320])
    """(height, width) [px]"""


class ThreeweRobot(Robot):
    """See the module."""

    config_class = ThreeweRobotConfig
    name = "threewe"

    def __init__(self, config: ThreeweRobotConfig) -> None:
        super().__init__(config)
        self.config = config
        self.cameras: dict[str, Any] = {"camera": None}  # LeRobot counts them for its writers
        self._profile = RobotProfile.load(config.hardware)
        self._robot: SyncRobot | None = None

    @property
    def observation_features(self) -> dict[str, Any]:
        """Velocities, and the camera's picture where there is one."""
        picture = {"camera": (*self.config.image_size, 3)} if self._profile.camera else {}
        return {**dict.fromkeys(NAMES, float), **picture}

    @property
    def action_features(self) -> dict[str, Any]:
        """Velocities that its base can have."""
        differential = self._profile.kinematics is Kinematics.differential
        return {name: float for name in NAMES if not (differential and name == "vy.vel")}

    @property
    def is_connected(self) -> bool:
        """Whether it can drive."""
        return self._robot is not None

    def connect(self, calibrate: bool = True) -> None:
        """Connects; there is nothing to calibrate."""
        del calibrate
        options = self.config
        size = tuple(options.image_size) if self._profile.camera else None
        self._robot = SyncRobot(
            options.backend, options.hardware, options.scene, seed=options.seed, realtime=True, image_size=size
        )
        self._robot.connect()

    @property
    def is_calibrated(self) -> bool:
        """Always."""
        return True

    def calibrate(self) -> None:
        """`threewe calibrate` measures a robot."""

    def configure(self) -> None:
        """Nothing is to be set."""

    def get_observation(self) -> dict[str, Any]:
        """The newest velocities and picture, RGB."""
        robot = self._connected()
        velocity = robot.get_velocity()
        numbers = dict(zip(NAMES, (velocity.vx, velocity.vy, velocity.omega), strict=True))
        picture = {"camera": np.ascontiguousarray(robot.get_image()[:, :, ::-1])} if self._profile.camera else {}
        return {**numbers, **picture}

    def send_action(self, action: dict[str, Any]) -> dict[str, Any]:
        """Drives; returns what was within the robot's limits of it."""
        limits = self._profile.operating_limits
        names = self.action_features
        vx, vy, omega = (float(action[name]) if name in names else 0.0 for name in NAMES)
        factor = min(1.0, limits.linear / max(math.hypot(vx, vy), 1e-9))
        turn = min(max(omega, -limits.angular), limits.angular)
        self._connected().set_velocity(factor * vx, factor * vy, turn, hold=HOLD)
        sent = dict(zip(NAMES, (factor * vx, factor * vy, turn), strict=True))
        return {name: sent[name] for name in names}

    def disconnect(self) -> None:
        """Stops and ends the connection."""
        if self._robot is not None:
            robot, self._robot = self._robot, None
            robot.disconnect()

    def _connected(self) -> SyncRobot:
        if self._robot is None:
            raise ConnectionError(f"{self} is not connected")
        return self._robot
